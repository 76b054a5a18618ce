/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Lets a word of flash be read whose checksum is wrong.
 *
 * A double word that was being programmed or erased when power failed may have two wrong bits or
 * more. An STM32G4 then answers each read of it with the bits as they are, and an NMI (RM0440,
 * 3.3.9). Zephyr's NMI handler waits for the watchdog, and the next start reads the word again: one
 * cut at the wrong moment, and the light never starts any more. Here the NMI is acknowledged and
 * the read goes on; whoever has read the word, the settings' NVS and its owner, has checksums of
 * his own.
 *
 * Any other NMI still waits for the watchdog, and so for the lamp's being off.
 */
#include <zephyr/init.h>
#include <zephyr/kernel.h>

#include <soc.h>

/* Zephyr 3.4 has it in another header than 3.7. */
void z_arm_nmi_set_handler(void (*handler)(void));

static void on_nmi(void)
{
	/* The bits are cleared by writing ones; those of the other kind stay. */
	const uint32_t wrong = FLASH->ECCR & (FLASH_ECCR_ECCD | FLASH_ECCR_ECCD2);
	const uint32_t rest = FLASH->ECCR & FLASH_ECCR_ECCIE;

	while (wrong == 0) {
	}
	FLASH->ECCR = rest | wrong;
}

static int flash_ecc_stm32g4_init(void)
{
	z_arm_nmi_set_handler(on_nmi);
	return 0;
}

/* Before anybody reads flash but to run from it. */
SYS_INIT(flash_ecc_stm32g4_init, PRE_KERNEL_1, 0);
