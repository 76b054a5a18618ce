/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The 256 initializers of a table that has an entry for each byte: BYTE_TABLE(OF) is OF(0u), OF(1u)
 * … OF(255u), constant expressions.
 */
#ifndef PHAROS_CORE_BYTE_TABLE_H
#define PHAROS_CORE_BYTE_TABLE_H

#define BYTE_TABLE_4(of, byte) of((byte)), of((byte) + 1u), of((byte) + 2u), of((byte) + 3u)
#define BYTE_TABLE_16(of, byte)                                                                    \
	BYTE_TABLE_4(of, (byte)), BYTE_TABLE_4(of, (byte) + 4u), BYTE_TABLE_4(of, (byte) + 8u),    \
		BYTE_TABLE_4(of, (byte) + 12u)
#define BYTE_TABLE_64(of, byte)                                                                    \
	BYTE_TABLE_16(of, (byte)), BYTE_TABLE_16(of, (byte) + 16u),                                \
		BYTE_TABLE_16(of, (byte) + 32u), BYTE_TABLE_16(of, (byte) + 48u)
#define BYTE_TABLE(of)                                                                             \
	BYTE_TABLE_64(of, 0u), BYTE_TABLE_64(of, 64u), BYTE_TABLE_64(of, 128u),                    \
		BYTE_TABLE_64(of, 192u)

#endif
