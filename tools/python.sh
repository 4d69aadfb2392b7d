#!/bin/sh
# Prints a Python for .venv: 3.11 where there is one (the bpy wheels of 4.5 and 5.0 are made for it),
# else 3.13, 3.12 or newer. PYTHON, where set, is taken as it is. Exits with 1 where there is none.
if [ -n "${PYTHON:-}" ]; then
  echo "$PYTHON"
  exit 0
fi
for python in python3.11 /usr/bin/python3.11 python3 python3.13 python3.12; do
  # venv alone is not enough, pip comes from ensurepip; the headers are for the native module.
  if "$python" -c 'import ensurepip, os, sys, sysconfig, venv
header = os.path.join(sysconfig.get_path("include"), "Python.h")
sys.exit(sys.version_info < (3, 11) or not os.path.exists(header))' 2> /dev/null; then
    "$python" -c 'import sys; print(sys.executable)'
    exit 0
  fi
done
echo "No Python 3.11 or newer with venv and headers (Debian: python3-venv python3-dev)" >&2
exit 1
