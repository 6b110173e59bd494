# How our targets are compiled, and which optional libraries are there.
include(CheckCXXCompilerFlag)
include(CheckPIESupported)
check_pie_supported()

# What every target of ours is compiled and linked with; not exported.
add_library(vsfind_options INTERFACE)
target_compile_options(vsfind_options INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion
  $<$<BOOL:${VSFIND_WERROR}>:-Werror>
  # GCC 12 takes plain string concatenations for overlapping copies (its bug 105651).
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>)
if(VSFIND_PRECOMPILE AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  target_compile_options(vsfind_options INTERFACE -fpch-preprocess)  # ccache wants it
endif()
if(VSFIND_FUZZ)
  if(NOT CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
    message(FATAL_ERROR "VSFIND_FUZZ needs clang (Debian: clang, libclang-rt-14-dev): cmake --preset fuzz")
  endif()
  target_compile_options(vsfind_options INTERFACE -fsanitize=fuzzer-no-link)
endif()
if(VSFIND_SANITIZE)
  target_compile_options(vsfind_options INTERFACE
    -fsanitize=${VSFIND_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all
    # GCC's own instrumentation hides assignments from this warning; the other builds keep it.
    $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
  target_link_options(vsfind_options INTERFACE -fsanitize=${VSFIND_SANITIZE})
else()
  # Parsers read hostile files: the release build is hardened. Fortified functions need optimization, and hide faults
  # from the sanitizers.
  set(optimized $<CONFIG:Release,RelWithDebInfo,MinSizeRel>)
  target_compile_options(vsfind_options INTERFACE
    "$<${optimized}:-U_FORTIFY_SOURCE;-D_FORTIFY_SOURCE=2;-fstack-protector-strong>")
  foreach(flag -fstack-clash-protection -fcf-protection)  # not on every processor
    string(MAKE_C_IDENTIFIER "VSFIND_HAS${flag}" has)
    check_cxx_compiler_flag(${flag} ${has})
    if(${has})
      target_compile_options(vsfind_options INTERFACE $<${optimized}:${flag}>)
    endif()
  endforeach()
  target_link_options(vsfind_options INTERFACE LINKER:-z,relro,-z,now LINKER:-z,noexecstack)
endif()
if(VSFIND_COVERAGE)
  # Threads count at once.
  target_compile_options(vsfind_options INTERFACE --coverage -fprofile-update=atomic)
  target_link_options(vsfind_options INTERFACE --coverage)
endif()
# The standard library's own checks, where speed does not matter.
if(VSFIND_SANITIZE OR CMAKE_BUILD_TYPE STREQUAL "Debug")
  target_compile_definitions(vsfind_options INTERFACE _GLIBCXX_ASSERTIONS)
endif()

# vsfind_optional_module(NAME MODULE PACKAGE): looks for a pkg-config module as VSFIND_WITH_<NAME> says. Sets
# VSFIND_<NAME>_FOUND, and VSFIND_<NAME>_WHY_NOT to a reason for the summary.
macro(vsfind_optional_module name module package)
  set(VSFIND_${name}_MODULE ${module})
  set(VSFIND_${name}_FOUND FALSE)
  string(TOUPPER "${VSFIND_WITH_${name}}" vsfind_wanted)
  if(vsfind_wanted STREQUAL "AUTO")
    find_package(PkgConfig QUIET)
  elseif(VSFIND_WITH_${name})
    find_package(PkgConfig REQUIRED)
  endif()
  if(NOT vsfind_wanted STREQUAL "AUTO" AND NOT VSFIND_WITH_${name})
    set(VSFIND_${name}_WHY_NOT "VSFIND_WITH_${name}=${VSFIND_WITH_${name}}")
  elseif(NOT PkgConfig_FOUND)
    set(VSFIND_${name}_WHY_NOT "pkg-config not found")
  else()
    pkg_check_modules(VSFIND_${name} QUIET IMPORTED_TARGET ${module})
    if(NOT VSFIND_${name}_FOUND AND NOT vsfind_wanted STREQUAL "AUTO")
      message(FATAL_ERROR "VSFIND_WITH_${name}=${VSFIND_WITH_${name}}, but pkg-config does not find ${module} (Debian: ${package})")
    endif()
    set(VSFIND_${name}_WHY_NOT "${module} not found, Debian: ${package}")
  endif()
endmacro()
