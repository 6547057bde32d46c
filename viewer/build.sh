#!/usr/bin/env bash
# Makes dist/viewer.js, the one script of the page, and its hash: from src, three.js and nothing else.
# Run `npm ci --ignore-scripts` first. With a folder as argument, puts both there.
set -euo pipefail
cd "$(dirname "$0")"
out="${1:-dist}"
mkdir -p "$out"

{
    echo "/*! bumper's viewer. It contains three.js (https://threejs.org), which has this licence:"
    echo
    cat node_modules/three/LICENSE
    echo "*/"
} > "$out/licence.txt"
node_modules/.bin/esbuild src/main.js --bundle --minify --format=iife --target=es2022 --charset=ascii \
    --legal-comments=none --log-level=warning --banner:js="$(cat "$out/licence.txt")" \
    --outfile="$out/viewer.js"
rm "$out/licence.txt"
openssl dgst -sha256 -binary "$out/viewer.js" | openssl base64 -A > "$out/viewer.js.sha256"
