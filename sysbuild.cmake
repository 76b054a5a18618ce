# SPDX-License-Identifier: Apache-2.0
#
# For sysbuild: the bootloader has the same partitions as the firmware.
set(partitions ${CMAKE_CURRENT_LIST_DIR}/boards/${BOARD}_partitions.dtsi)
if(SB_CONFIG_BOOTLOADER_MCUBOOT AND EXISTS ${partitions})
  set(mcuboot_EXTRA_DTC_OVERLAY_FILE ${partitions} CACHE INTERNAL "Pharos' partitions")
endif()
