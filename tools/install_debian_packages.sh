#!/bin/sh
# Installs the packages of tools/debian_packages.txt that are missing, where apt-get may be used;
# says which are missing and how to install them where it may not. Never fails: what can be done
# without them is done, and what cannot says so itself.
list="$(dirname "$0")/debian_packages.txt"

installed() {
  [ "$(dpkg-query -W -f '${db:Status-Abbrev}' "$1" 2> /dev/null | cut -c1-2)" = "ii" ]
}

# Of each line NAME|ALTERNATIVE..., the first that apt knows, unless one is installed. clang and
# libomp must be of one version, so the alternatives stand in the same order in both lines.
missing() {
  grep -v '^#' "$list" | while read -r names _; do
    [ -n "$names" ] || continue
    chosen=""
    for name in $(echo "$names" | tr '|' ' '); do
      if installed "$name"; then
        chosen=""
        continue 2
      fi
      if [ -z "$chosen" ] && apt-cache show "$name" > /dev/null 2>&1; then chosen="$name"; fi
    done
    echo "${chosen:-${names%%|*}}"
  done
}

if ! command -v dpkg-query > /dev/null || ! command -v apt-get > /dev/null; then
  echo "Not a Debian or Ubuntu machine: the packages of $list have to be there by other means."
  exit 0
fi
wanted=$(missing)
[ -n "$wanted" ] || exit 0
if [ "$(id -u)" = 0 ]; then
  root=""
elif sudo -n true 2> /dev/null; then
  root="sudo -n"
else
  echo "Missing Debian packages (apt-get needs root, which is not to be had without a password):"
  echo "$wanted" | sed 's/^/    /'
  echo "Install them with: sudo apt-get install" $wanted
  exit 0
fi
echo "Installing Debian packages:" $wanted
export DEBIAN_FRONTEND=noninteractive
$root apt-get update -q -q || echo "apt-get update failed; going on with the lists that are there"
wanted=$(missing)
if ! $root apt-get install -q -q -y --no-install-recommends $wanted; then
  # One that cannot be had must not keep the others away.
  for name in $wanted; do
    $root apt-get install -q -q -y --no-install-recommends "$name" || echo "Not installed: $name"
  done
fi
exit 0
