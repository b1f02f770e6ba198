#!/usr/bin/env bash
# Do two builds of the program write the same files? For changes that must not change a tree.
#
#   tests/same_bytes.sh OLD NEW [MODEL…]     programs, then models (default: samples/*.obj, samples/*.gltf, samples/*.glb)
#
# Every model is built by several recipes with each program, and the files are compared byte by byte. A model that one program refuses
# and the other takes is a difference as well. One that both refuse is counted apart; any other end of a program, or nothing to compare, fails.
# Where files differ, the sections are named that do. Environment: BVHC_RECIPES, a list of recipes separated by `;`, and BVHC_SECTIONS, the types of
# sections that are compared alone, such as "NODE TRIS BLAS".
set -u
[ $# -ge 2 ] || { sed -n '2,10s/^# \{0,1\}//p' "$0"; exit 2; }
old=$1 new=$2
shift 2
here=$(cd "$(dirname "$0")/.." && pwd)
[ $# -gt 0 ] || set -- "$here"/samples/*.obj "$here"/samples/*.gltf "$here"/samples/*.glb
IFS=';' read -ra recipes <<<"${BVHC_RECIPES:---preset draft;--preset balanced;--method sbvh;--method bonsai;--method agglomerative;--method sweep --reinsert 2;--preset draft --levels two}"
out=$(mktemp -d)

# The types of the sections of two files that have other bytes, or that one file alone has.
sections() {
    local file
    for file in "$out/old.bvhc" "$out/new.bvhc"; do
        "$new" info "$file" --json >"$file.json" 2>/dev/null || { echo "in a file that cannot be read"; return 0; }
    done
    python3 - "$out/old.bvhc.json" "$out/new.bvhc.json" "${BVHC_SECTIONS:-}" <<'EOF'
import json, sys
a, b = ({s["type"]: s["raw_hash"] for s in json.load(open(f))["files"][0]["sections"]} for f in sys.argv[1:3])
wanted = set(sys.argv[3].split()) or a.keys() | b.keys()
differ = sorted(k for k in wanted if a.get(k) != b.get(k))
print(*["in"] * bool(differ), *differ)
EOF
}
trap 'rm -rf "$out"' EXIT
same=0 differ=0 refused=0
for model in "$@"; do
    for recipe in "${recipes[@]}"; do
        read -ra flags <<<"$recipe"
        "$old" build "$model" -o "$out/old.bvhc" --force -q "${flags[@]}" >/dev/null 2>&1
        a=$?
        "$new" build "$model" -o "$out/new.bvhc" --force -q "${flags[@]}" >/dev/null 2>&1
        b=$?
        if [ $a = 0 ] && [ $b = 0 ] && { cmp -s "$out/old.bvhc" "$out/new.bvhc" || { [ -n "${BVHC_SECTIONS:-}" ] && [ -z "$(sections)" ]; }; }; then
            same=$((same + 1))
        elif [ $a = $b ] && { [ $a = 4 ] || [ $a = 5 ]; }; then # a model that is malformed, or a feature of it that is not supported
            refused=$((refused + 1))
        else
            differ=$((differ + 1))
            echo "differs: $model by $recipe (exit $a and $b)" "$([ $a = 0 ] && [ $b = 0 ] && sections)"
        fi
        rm -f "$out"/*.bvhc
    done
done
echo "$same equal, $differ different, $refused refused by both"
[ $differ = 0 ] && [ $same -gt 0 ]
