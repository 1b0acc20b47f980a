#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Makes the Debian packages, checks them with lintian, unpacks them into a folder and builds programs against that folder.
# By hand, not in continuous integration: it builds the command and every module first. Needs dpkg-dev and lintian.
#   bash test/packages.sh
set -eu
cd "$(dirname "${BASH_SOURCE[0]}")/.."
. cmake/setup.sh
choose_tools
need_packages $build_packages $reference_packages dpkg-dev lintian

# Explained in docs/how-to/install.md.
explained=maintscript-calls-ldconfig

export DEBFULLNAME=${DEBFULLNAME:-Test} DEBEMAIL=${DEBEMAIL:-test@example.com}
build=build/deb
packages=$PWD/$build/packages
root=$PWD/$build/unpacked
cmake --preset deb >/dev/null
cmake --build --preset deb -j "$jobs"
rm -rf "$packages" "$root"
cpack -G DEB --config $build/CPackConfig.cmake -B "$packages" >/dev/null
rm -rf "$packages/_CPack_Packages"
ls -l "$packages"
lintian --allow-root --fail-on error,warning --suppress-tags $explained "$packages"/*.deb

for package in "$packages"/*.deb; do dpkg -x "$package" "$root"; done
libdir=$root/usr/lib/$(dpkg-architecture -q DEB_HOST_MULTIARCH)
export LD_LIBRARY_PATH=$libdir PKG_CONFIG_PATH=$libdir/pkgconfig
cmake -S test/consumer/project -B $build/consumer -DDYNFILTER_FROM=package -DCMAKE_PREFIX_PATH="$root/usr" >/dev/null
cmake --build $build/consumer
$build/consumer/consumer
cc test/consumer/project/plain_c.c -o $build/plain_c $(pkg-config --cflags --libs dynfilter-facade)
$build/plain_c
"$root/usr/bin/dynfilter" check dynfilter
grep -q "dynfilter::Pipeline" "$root/usr/share/doc/dynfilter-doc/html/index.html"
if grep -rlaF "$PWD" "$root/usr"; then
  echo "these files name the build tree"
  exit 1
fi
echo "packages: all right"
