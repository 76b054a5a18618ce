/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Turns on the FIFOs of the links' UARTs: 8 bytes on an STM32G4, 16 on an H7; an F4 has none.
 * Up to Zephyr 3.5 its driver reads and fills them but leaves them off; from 3.6 on this is not
 * built, and the devicetree says fifo-enable. Without, a byte is lost when an interrupt waits for
 * longer than a byte takes.
 */
#include <zephyr/devicetree.h>
#include <zephyr/init.h>

#include <soc.h>
#include <stm32_ll_usart.h>

/* The driver has set up the UART before; the FIFO can be turned on while the UART is off only. */
static __maybe_unused void turn_on(USART_TypeDef *uart)
{
#ifdef USART_CR1_FIFOEN
	if (IS_UART_FIFO_INSTANCE(uart)) {
		LL_USART_Disable(uart);
		LL_USART_EnableFIFO(uart);
		LL_USART_Enable(uart);
	}
#endif
}

#define TURN_ON(alias)                                                                             \
	IF_ENABLED(DT_NODE_HAS_COMPAT(DT_ALIAS(alias), st_stm32_uart),                             \
	           (turn_on((USART_TypeDef *)DT_REG_ADDR(DT_ALIAS(alias)));))

static int uart_fifo_stm32_init(void)
{
	TURN_ON(uart_link0)
	TURN_ON(uart_link1)
	TURN_ON(uart_link2)
	TURN_ON(uart_link3)
	return 0;
}

SYS_INIT(uart_fifo_stm32_init, POST_KERNEL, CONFIG_PHAROS_DRIVERS_INIT_PRIORITY);
