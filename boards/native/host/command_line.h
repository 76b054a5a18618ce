/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The command line: `--name VALUE` and `--name=VALUE` are the same. The options are those of all
 * modules' tables (host/options.h). A wrong one is one line on stderr (what is wrong, what would be
 * right) and exit status 2.
 */
#ifndef NATIVE_HOST_COMMAND_LINE_H_
#define NATIVE_HOST_COMMAND_LINE_H_

/* Exits for --help, --version and wrong options; else all options have been parsed, in their given
 * order. */
void command_line_parse(int argc, char *const argv[]);

#endif
