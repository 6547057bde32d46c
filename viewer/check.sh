#!/usr/bin/env bash
# That the committed bundle is what its source and the locked packages make, byte for byte.
set -euo pipefail
cd "$(dirname "$0")"
npm ci --ignore-scripts --no-audit --no-fund
fresh="$(mktemp -d)"
trap 'rm -rf "$fresh"' EXIT
./build.sh "$fresh"
for file in viewer.js viewer.js.sha256; do
    cmp "dist/$file" "$fresh/$file" || {
        echo "viewer/dist/$file is not what viewer/src makes: run viewer/build.sh and commit it" >&2
        exit 1
    }
done
echo "viewer/dist is what viewer/src makes"
