#!/usr/bin/env bash
# Do two builds of the program write the same files? For changes that must not change a tree.
#
#   tests/same_bytes.sh OLD NEW [MODEL…]     programs, then models (default: samples/*.obj, samples/*.gltf, samples/*.glb)
#
# Every model is built by several recipes with each program, and the files are compared byte by byte. A model that one program refuses
# and the other takes is a difference as well. Environment: BVHC_RECIPES, a list of recipes separated by `;`.
set -u
old=$1 new=$2
shift 2
here=$(cd "$(dirname "$0")/.." && pwd)
[ $# -gt 0 ] || set -- "$here"/samples/*.obj "$here"/samples/*.gltf "$here"/samples/*.glb
IFS=';' read -ra recipes <<<"${BVHC_RECIPES:---preset draft;--preset balanced;--method sbvh;--method bonsai;--method agglomerative;--method sweep --reinsert 2;--preset draft --levels two}"
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
same=0 differ=0
for model in "$@"; do
    for recipe in "${recipes[@]}"; do
        read -ra flags <<<"$recipe"
        "$old" build "$model" -o "$out/old.bvhc" --force -q "${flags[@]}" >/dev/null 2>&1
        a=$?
        "$new" build "$model" -o "$out/new.bvhc" --force -q "${flags[@]}" >/dev/null 2>&1
        b=$?
        if [ $a = $b ] && { [ $a != 0 ] || cmp -s "$out/old.bvhc" "$out/new.bvhc"; }; then
            same=$((same + 1))
        else
            differ=$((differ + 1))
            echo "differs: $model by $recipe (exit $a and $b)"
        fi
        rm -f "$out"/*.bvhc
    done
done
echo "$same equal, $differ different"
[ $differ = 0 ]
