#!/bin/sh
# Prints the C++ compiler for the native module: clang 16 or newer with its OpenMP runtime, else g++.
# CXX, where set, is taken as it is. Exits with 1 where there is none.
if [ -n "${CXX:-}" ]; then
  echo "$CXX"
  exit 0
fi
probe=$(mktemp -d)
trap 'rm -rf "$probe"' EXIT
echo '#include <omp.h>
#include <cmath>
int main() { return omp_get_max_threads() < 1; }' > "$probe/probe.cpp"
for compiler in clang++-19 clang++-18 clang++-17 clang++-16 clang++; do
  command -v "$compiler" > /dev/null || continue
  version=$("$compiler" -dumpversion)
  [ "${version%%.*}" -ge 16 ] || continue
  # Several clangs may be installed, and the OpenMP runtime of one of them only.
  if "$compiler" -std=c++20 -fopenmp "$probe/probe.cpp" -o "$probe/probe" 2> /dev/null; then
    echo "$compiler"
    exit 0
  fi
done
if command -v g++ > /dev/null; then
  echo "No clang 16 or newer with libomp: building with g++, which gives the same bits and runs slower" >&2
  echo g++
  exit 0
fi
echo "No C++ compiler: clang 16 or newer with libomp (Debian: clang-19 libomp-19-dev) or g++ is needed" >&2
exit 1
