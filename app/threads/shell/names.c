/* SPDX-License-Identifier: Apache-2.0 */
#include "threads/shell/names.h"

#include <ctype.h>
#include <stddef.h>
#include <string.h>

bool names_begin(const char *name, const char *word)
{
	size_t i = 0;

	while (word[i] != '\0' &&
	       toupper((unsigned char)name[i]) == toupper((unsigned char)word[i])) {
		i++;
	}
	return word[i] == '\0';
}

bool names_equal(const char *name, const char *word)
{
	return strlen(name) == strlen(word) && names_begin(name, word);
}
