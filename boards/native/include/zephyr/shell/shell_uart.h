/* SPDX-License-Identifier: Apache-2.0 */
/* The shell on the UART that /chosen names zephyr,shell-uart. */
#ifndef ZEPHYR_SHELL_SHELL_UART_H
#define ZEPHYR_SHELL_SHELL_UART_H

#include <zephyr/shell/shell.h>

const struct shell *shell_backend_uart_get_ptr(void);

#endif
