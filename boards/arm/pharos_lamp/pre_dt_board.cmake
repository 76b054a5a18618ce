# SPDX-License-Identifier: Apache-2.0
if(KERNEL_VERSION_STRING VERSION_LESS 3.7)
  set(BOARD_DEFCONFIG ${BOARD_DIR}/pharos_lamp_defconfig ${BOARD_DIR}/pharos_lamp_soc.conf)
endif()
