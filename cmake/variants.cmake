# openmp_loops.cpp as one object library for each of ISOPHOTE_VARIANTS; sets variant_objects,
# strict_flags, kernel_warnings, include_dirs, and writes isophote_build.h.
#
# The order counts: of an inline function of the standard library that several variants hold, the
# linker keeps the first, so the variant for the oldest processor comes first.

# What keeps the bits equal everywhere, and what lets the loops vectorise without changing a bit:
# no fused multiply-add that nobody wrote, no errno, no traps to keep in order.
set(strict_flags -ffp-contract=off -fno-math-errno -fno-trapping-math)
# Closures share one signature, also where one has no use for a parameter.
set(kernel_warnings -Wall -Wextra -Wno-unused-parameter -Wdouble-promotion -Werror)

string(TOLOWER "${CMAKE_CXX_COMPILER_ID}" compiler_id)
if(compiler_id STREQUAL "clang")
  if(CMAKE_CXX_COMPILER_VERSION VERSION_LESS 16)
    message(FATAL_ERROR "clang ${CMAKE_CXX_COMPILER_VERSION} gives up on the loops: clang 16 or newer, or g++, is needed")
  endif()
  # A loop that is marked `omp simd` and does not vectorise stops the build.
  set(vector_flags -Werror=pass-failed)
  set(report_flags -fsave-optimization-record -foptimization-record-passes=loop-vectorize)
else()
  message(WARNING "Building with ${CMAKE_CXX_COMPILER_ID} ${CMAKE_CXX_COMPILER_VERSION}: the same bits, but the shading "
                  "loops run several times slower than with clang 16 or newer")
  set(vector_flags "")
  set(report_flags -fopt-info-vec-optimized)
endif()
if(compiler_id STREQUAL "gnu")
  set(compiler_id "g++")
endif()

set(include_dirs "${CMAKE_SOURCE_DIR}/kernels" "${CMAKE_SOURCE_DIR}/native" "${ISOPHOTE_NATIVE_DIR}")

set(variant_objects "")
set(variant_list "")
foreach(variant IN LISTS ISOPHOTE_VARIANTS)
  string(REGEX MATCH "^([a-z]+)_v?([a-z0-9]+)$" matched "${variant}")
  set(precision "${CMAKE_MATCH_1}")
  set(level "${CMAKE_MATCH_2}")
  set(target "openmp_loops_${variant}")
  add_library(${target} OBJECT "${ISOPHOTE_NATIVE_DIR}/openmp_loops.cpp")
  target_include_directories(${target} PRIVATE ${include_dirs})
  target_compile_definitions(${target} PRIVATE ISOPHOTE_VARIANT=${variant})
  target_compile_options(${target} PRIVATE ${strict_flags} ${kernel_warnings} ${OpenMP_CXX_FLAGS})
  if(level STREQUAL "native")
    set(level 0)
  else()
    target_compile_options(${target} PRIVATE -march=x86-64-v${level})
  endif()
  if(level STREQUAL "4")
    target_compile_options(${target} PRIVATE -mprefer-vector-width=512)
  endif()
  if(precision STREQUAL "fast")
    target_compile_definitions(${target} PRIVATE ISOPHOTE_FAST)
    # STRICT_FP in the kernels asks for strictness function by function, which only clang heeds.
    if(compiler_id STREQUAL "clang")
      target_compile_options(${target} PRIVATE -ffp-contract=fast-honor-pragmas)
    endif()
  elseif(precision STREQUAL "reference")
    # In double everything is promoted, and speed is not what it is for.
    target_compile_definitions(${target} PRIVATE ISOPHOTE_REFERENCE)
    target_compile_options(${target} PRIVATE -Wno-double-promotion -Wno-pass-failed)
  endif()
  if(NOT precision STREQUAL "reference")
    target_compile_options(${target} PRIVATE ${vector_flags})
  endif()
  if(ISOPHOTE_COMPILER_REPORT)
    target_compile_options(${target} PRIVATE ${report_flags})
  endif()
  list(APPEND variant_objects $<TARGET_OBJECTS:${target}>)
  string(APPEND variant_list " X(${variant}, ${precision}, ${level})")
endforeach()

set(ISOPHOTE_COMPILER "${compiler_id} ${CMAKE_CXX_COMPILER_VERSION}")
configure_file("${CMAKE_SOURCE_DIR}/cmake/isophote_build.h.in" "${CMAKE_BINARY_DIR}/generated/isophote_build.h" @ONLY)
