# SPDX-License-Identifier: Apache-2.0
#
# cmake -D SOURCE=<tree> -D OUT=<header> -P vcs_commit.cmake: the commit that is being built, as
# protocols tell it. Outside of a git tree it is 0, "not known". Written only when it changes.
find_program(GIT git)
if(GIT)
  execute_process(
    COMMAND ${GIT} rev-parse --verify --short=8 HEAD
    WORKING_DIRECTORY ${SOURCE}
    OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
endif()
# git makes it longer where eight digits are not unique.
string(SUBSTRING "${commit}" 0 8 commit)
if(NOT commit MATCHES "^[0-9a-f]+$")
  set(commit 0)
endif()
set(text "/* SPDX-License-Identifier: Apache-2.0 */\n#define PHAROS_VCS_COMMIT 0x${commit}u\n")
if(EXISTS ${OUT})
  file(READ ${OUT} old)
endif()
if(NOT "${old}" STREQUAL "${text}")
  file(WRITE ${OUT} "${text}")
endif()
