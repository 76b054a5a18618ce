# SPDX-License-Identifier: Apache-2.0
#
# Before find_package(Zephyr): the module and the boards in this repository, and Zephyr's version for
# devicetree overlays, as ZV: 30400 for 3.4.0. Work towards the next version has the patch level 99,
# so what is new in 4.2 is asked for as ZV >= 40199.

get_filename_component(PHAROS_ROOT ${CMAKE_CURRENT_LIST_DIR}/.. ABSOLUTE)
list(APPEND ZEPHYR_EXTRA_MODULES ${PHAROS_ROOT})

if(NOT DEFINED ZEPHYR_BASE)
  set(ZEPHYR_BASE $ENV{ZEPHYR_BASE})
endif()
if(NOT ZEPHYR_BASE)
  message(FATAL_ERROR "ZEPHYR_BASE is not set: build with west, or source zephyr-env.sh")
endif()
file(STRINGS ${ZEPHYR_BASE}/VERSION PHAROS_ZEPHYR_VERSION
  REGEX "^(VERSION_MAJOR|VERSION_MINOR|PATCHLEVEL) *=")
list(TRANSFORM PHAROS_ZEPHYR_VERSION REPLACE "[^0-9]" "")
list(GET PHAROS_ZEPHYR_VERSION 0 PHAROS_ZEPHYR_MAJOR)
list(GET PHAROS_ZEPHYR_VERSION 1 PHAROS_ZEPHYR_MINOR)
list(GET PHAROS_ZEPHYR_VERSION 2 PHAROS_ZEPHYR_PATCH)
math(EXPR PHAROS_ZV
  "${PHAROS_ZEPHYR_MAJOR} * 10000 + ${PHAROS_ZEPHYR_MINOR} * 100 + ${PHAROS_ZEPHYR_PATCH}")
list(APPEND DTS_EXTRA_CPPFLAGS "-DZV=${PHAROS_ZV}")

# From 4.4 a board.yml must have a full_name, which 3.7 refuses; and one bad board.yml in a root
# stops the build of any board.
set(PHAROS_BOARD_ROOT ${PHAROS_ROOT})
if(PHAROS_ZV GREATER_EQUAL 40399)
  set(PHAROS_BOARD_ROOT ${CMAKE_BINARY_DIR}/pharos)
  file(COPY ${PHAROS_ROOT}/boards/arm DESTINATION ${PHAROS_BOARD_ROOT}/boards)
  file(APPEND ${PHAROS_BOARD_ROOT}/boards/arm/pharos_lamp/board.yml
    "  full_name: Pharos example lamp\n")
endif()
list(APPEND BOARD_ROOT ${PHAROS_BOARD_ROOT})
