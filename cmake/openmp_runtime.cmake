# Finds the OpenMP runtime that the module is linked with, so that it can be laid beside the module:
# machines without clang have no libomp. Sets openmp_runtime_file and openmp_runtime_name (the soname).
list(GET OpenMP_CXX_LIB_NAMES 0 openmp_lib)
set(openmp_library "${OpenMP_${openmp_lib}_LIBRARY}")
if(openmp_library MATCHES "libgomp")
  # gcc's own folder may hold a linker script or a link; the compiler knows the shared library.
  execute_process(COMMAND "${CMAKE_CXX_COMPILER}" -print-file-name=libgomp.so.1
                  OUTPUT_STRIP_TRAILING_WHITESPACE OUTPUT_VARIABLE openmp_library)
endif()
file(REAL_PATH "${openmp_library}" openmp_runtime_file)
find_program(READELF NAMES readelf llvm-readelf llvm-readelf-19 llvm-readelf-18 llvm-readelf-17 llvm-readelf-16 REQUIRED)
execute_process(COMMAND "${READELF}" -d "${openmp_runtime_file}" OUTPUT_VARIABLE dynamic_section)
if(NOT dynamic_section MATCHES "SONAME[^\\[]*\\[([^]]+)\\]")
  message(FATAL_ERROR "${openmp_runtime_file}: not a shared OpenMP runtime")
endif()
set(openmp_runtime_name "${CMAKE_MATCH_1}")
