# SPDX-License-Identifier: Apache-2.0
#
# For any application: pharos_lamp.dts asks for Zephyr's version (zephyr/app.cmake says how).
math(EXPR zv
  "${KERNEL_VERSION_MAJOR} * 10000 + ${KERNEL_VERSION_MINOR} * 100 + ${KERNEL_PATCHLEVEL}")
list(APPEND DTS_EXTRA_CPPFLAGS "-DZV=${zv}")

if(zv LESS 30699)
  set(BOARD_DEFCONFIG ${BOARD_DIR}/pharos_lamp_defconfig ${BOARD_DIR}/pharos_lamp_soc.conf)
endif()
