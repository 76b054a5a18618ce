# SPDX-License-Identifier: Apache-2.0
#
# BOARD=native: the part of Zephyr's build that the app and its drivers use, over our own port.
# Targets: zephyr_interface (flags and include paths), native_board (kernel, subsystems, host,
# devices, models and drivers), native_ztest, app (the program build/native/pharos).

find_package(Python3 REQUIRED COMPONENTS Interpreter)
find_package(PkgConfig REQUIRED)
pkg_check_modules(INIH REQUIRED IMPORTED_TARGET inih)
pkg_check_modules(JANSSON REQUIRED IMPORTED_TARGET jansson)
pkg_check_modules(NETTLE REQUIRED IMPORTED_TARGET nettle)

set(PHAROS_SANITIZE "" CACHE STRING "Sanitizers, as -fsanitize= takes them; empty for none")
option(PHAROS_FUZZ "Build the libFuzzer harnesses (clang only)" OFF)
set(PHAROS_FUZZ_ENGINE "" CACHE STRING
  "What the harnesses are linked with, where whoever builds also says how to compile; empty: libFuzzer")
option(PHAROS_COVERAGE "Instrument for gcov" OFF)

set(CMAKE_C_STANDARD 11)
set(CMAKE_C_STANDARD_REQUIRED ON)
set(CMAKE_C_EXTENSIONS ON)
set(CMAKE_C_FLAGS_RELWITHDEBINFO "-O2 -g")

set(NATIVE_DIR ${CMAKE_CURRENT_LIST_DIR})
set(PHAROS_DIR ${CMAKE_CURRENT_SOURCE_DIR})
set(GENERATED_DIR ${CMAKE_BINARY_DIR}/generated)

# --- configuration: Kconfig + prj.conf + native.conf -> autoconf.h -----------------------------
set(AUTOCONF_H ${GENERATED_DIR}/autoconf.h) # as Zephyr calls it
set(CONF_FILES ${PHAROS_DIR}/prj.conf ${NATIVE_DIR}/native.conf ${EXTRA_CONF_FILE})
execute_process(
  COMMAND ${Python3_EXECUTABLE} ${NATIVE_DIR}/scripts/kconfig.py
    --kconfig ${PHAROS_DIR}/Kconfig --srctree ${NATIVE_DIR}/kconfig
    --out ${GENERATED_DIR} --sources ${GENERATED_DIR}/kconfig_sources.txt ${CONF_FILES}
  COMMAND_ERROR_IS_FATAL ANY)
file(STRINGS ${GENERATED_DIR}/kconfig_sources.txt KCONFIG_SOURCES)
file(STRINGS ${GENERATED_DIR}/.config DOT_CONFIG REGEX "^CONFIG_[A-Z0-9_]+=")
foreach(line IN LISTS DOT_CONFIG)
  string(REGEX MATCH "^(CONFIG_[A-Z0-9_]+)=\"?([^\"]*)\"?$" _ "${line}")
  set(${CMAKE_MATCH_1} "${CMAKE_MATCH_2}")
endforeach()

# --- devicetree: native.dts + bindings -> devicetree_generated.h -------------------------------
set(NATIVE_BINDINGS ${PHAROS_DIR}/drivers/dts/bindings ${NATIVE_DIR}/dts/bindings)
execute_process(
  COMMAND ${Python3_EXECUTABLE} ${NATIVE_DIR}/scripts/gen_devicetree.py
    --dts ${NATIVE_DIR}/native.dts --bindings ${NATIVE_BINDINGS}
    --out ${GENERATED_DIR}/devicetree_generated.h
  COMMAND_ERROR_IS_FATAL ANY)
file(GLOB_RECURSE BINDING_FILES CONFIGURE_DEPENDS
  ${PHAROS_DIR}/drivers/dts/bindings/*.yaml ${NATIVE_DIR}/dts/bindings/*.yaml)
set_property(DIRECTORY ${PHAROS_DIR} APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS
  ${KCONFIG_SOURCES} ${BINDING_FILES} ${NATIVE_DIR}/native.dts
  ${NATIVE_DIR}/scripts/kconfig.py ${NATIVE_DIR}/scripts/gen_devicetree.py)

# --- version ----------------------------------------------------------------------------------
file(STRINGS ${PHAROS_DIR}/app/version.h VERSION_NUMBERS
  REGEX "^#define PHAROS_VERSION_(MAJOR|MINOR|PATCH) [0-9]+$")
list(TRANSFORM VERSION_NUMBERS REPLACE ".* " "")
list(JOIN VERSION_NUMBERS "." VERSION)
set_property(DIRECTORY ${PHAROS_DIR} APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS
  ${PHAROS_DIR}/app/version.h)

# --- flags ------------------------------------------------------------------------------------
add_library(zephyr_interface INTERFACE)
target_compile_options(zephyr_interface INTERFACE
  -Wall -Wextra $<$<NOT:$<BOOL:${PHAROS_FUZZ_ENGINE}>>:-Werror> -Wshadow -Wno-unused-parameter
  $<$<COMPILE_LANGUAGE:C>:-Wstrict-prototypes>
  -fno-common -fno-omit-frame-pointer
  -imacros ${GENERATED_DIR}/autoconf.h)
# The application's main() is a thread of the device; the process's own is boards/native/host/main.c.
target_compile_definitions(zephyr_interface INTERFACE _GNU_SOURCE main=zephyr_app_main)
target_include_directories(zephyr_interface INTERFACE
  ${NATIVE_DIR}/include ${PHAROS_DIR}/drivers/include ${GENERATED_DIR})
if(PHAROS_SANITIZE)
  add_compile_options(-fsanitize=${PHAROS_SANITIZE} -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${PHAROS_SANITIZE})
endif()
if(PHAROS_FUZZ AND NOT PHAROS_FUZZ_ENGINE)
  add_compile_options(-fsanitize=fuzzer-no-link)
endif()
if(PHAROS_COVERAGE)
  add_compile_options(--coverage)
  add_link_options(--coverage)
endif()

# --- Zephyr's library functions, so that drivers' CMakeLists.txt serve both kernels ------------
function(zephyr_library)
endfunction()

function(zephyr_library_sources)
  foreach(source IN LISTS ARGN)
    target_sources(native_board PRIVATE ${CMAKE_CURRENT_SOURCE_DIR}/${source})
  endforeach()
endfunction()

function(zephyr_library_sources_ifdef feature)
  if(${feature})
    zephyr_library_sources(${ARGN})
  endif()
endfunction()

# --- the board --------------------------------------------------------------------------------
add_library(native_board OBJECT)
target_link_libraries(native_board PUBLIC zephyr_interface PkgConfig::INIH PkgConfig::JANSSON
  PkgConfig::NETTLE m)
target_include_directories(native_board PRIVATE ${NATIVE_DIR})
# What the program calls itself, in --help and on the control socket.
target_compile_definitions(native_board PRIVATE PHAROS_VERSION="${VERSION}")
add_subdirectory(${NATIVE_DIR}/kernel)
add_subdirectory(${NATIVE_DIR}/subsys)
add_subdirectory(${NATIVE_DIR}/host)
add_subdirectory(${NATIVE_DIR}/models)
add_subdirectory(${NATIVE_DIR}/devices)
add_subdirectory(${NATIVE_DIR}/drivers)
add_subdirectory(drivers)

add_executable(app)
set_target_properties(app PROPERTIES
  OUTPUT_NAME pharos RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR})
target_link_libraries(app PRIVATE native_board zephyr_interface)
# Of the program alone: the tests, and so every board, have the core's own.
target_sources(app PRIVATE ${NATIVE_DIR}/host/sha256_nettle.c)

enable_testing()

# pharos_ztest(NAME name SOURCES file… [LIBRARIES target…]): one executable of ztest suites on the
# native kernel, and its ctest entry.
function(pharos_ztest)
  cmake_parse_arguments(ARG "" "NAME" "SOURCES;LIBRARIES" ${ARGN})
  add_executable(${ARG_NAME} ${ARG_SOURCES})
  target_link_libraries(${ARG_NAME} PRIVATE ${ARG_LIBRARIES} native_ztest native_board
    zephyr_interface)
  add_test(NAME ${ARG_NAME} COMMAND ${ARG_NAME} --time virtual --console none)
  set_tests_properties(${ARG_NAME} PROPERTIES TIMEOUT 600)
endfunction()
