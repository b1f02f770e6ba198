"""Small OBJ models. See `corners`."""

import math
import os

SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
SIX = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\n"


def ring(points, at=(0.0, 0.0, 0.0)):
    """One polygon through 2D points, tilted out of every axis plane but kept flat: z = x / 2 + y / 4."""
    lines = ["v %.9g %.9g %.9g" % (at[0] + x, at[1] + y, at[2] + x / 2 + y / 4) for x, y in points]
    return "\n".join(lines) + "\nf " + " ".join(str(i + 1) for i in range(len(points))) + "\n"


def star(n, inner=0.375):
    return [((1 if i % 2 else inner) * math.cos(math.pi * i / n), (1 if i % 2 else inner) * math.sin(math.pi * i / n)) for i in range(2 * n)]


def texts():
    yield "numbers", "v +1.5 -.5 2.\nv 1e-3 1E+2 0x\n".replace("0x", "1e2") + "v 1e-44 1.00000005960464477539062500000001 -0.0\nv 123456789.123456789 0.1 3\nf 1 2 3\nf 2 3 4\n"
    yield "line_ends", SQUARE.replace("\n", "\r\n") + "f 1 2 3\r\nf 1 3 4"
    yield "line_ends_old_mac", (SQUARE + "f 1 2 3\nf 1 3 4\n").replace("\n", "\r")
    yield "white_space", "\t v   0\t0 0  \n  v 1 0 0\nv\t1 1 0\nv 0 1 0\n\n   \n f  1  2\t3 \n"
    yield "mark", "\ufeff" + SQUARE + "f 1 2 3\n"
    yield "comments", "#v 9 9 9\n" + SQUARE + "f 1 2 3 # the first\nf 1 3 4 #and the second\nv 5 5 5 # v\n# f 1 2 5"
    yield "continued", "v 0 0 \\\n0\nv 1 0 0\nv 1 \\\n1 \\\n0\nv 0 1 0\nf 1 2 \\\n3 4\n"
    yield "continued_at_the_end", SQUARE + "f 1 2 3 \\\n4\\"
    yield "continued_at_the_end_and_zeros", SQUARE + "f 1 2 \\ \t\n3\\ \0\0\0"
    yield "continued_comments", SQUARE + "# C:\\models\\\nf 1 2 3\nf 1 \\\r\n2 \\\n4 # 3 \\\n# 4\nf 1 3 4\n\\\nf 2 3 4"
    yield "negative", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 5 5 5\nf -4 2 -1\nf 1/-1 2/-2/-3 -1//1\nvt 0 0\n"
    yield "corner_forms", SQUARE + "vt 0 0\nvn 0 0 1\nf 1/1 2/1 3/1\nf 1//1 3//1 4//1\nf 1/1/1 2/1/1 4/1/1\nf 1/ 2/ 3/\n"
    yield "old_faces", SQUARE + "fo 1 2 3\nf 1 3 4\n"
    yield "colours", "v 0 0 0 0.1 0.2 0.3\nv 1 0 0 1 1 1\nv 0 1 0 0 0 0\nf 1 2 3\n"
    yield "weight_one", "v 0 0 0 1\nv 1 0 0 1.0\nv 0 1 0 1\nf 1 2 3\n"
    yield "weights", "v 2 0 0 2\nv 1 0 0 0.5\nv 0 1 0 0.25\nf 1 2 3\n"
    yield "later_vertices", "f 1 2 3\n" + SQUARE
    yield "zeros_behind", SQUARE + "f 1 2 3\n" + "\0" * 9
    yield "zeros_far_behind", "# " + "-" * 9000 + "\n" + SQUARE + "f 1 2 3\n" + "\0" * 5000
    yield "no_obj", "version https://git-lfs.github.com/spec/v1\nsize 3\n"
    yield "upper_case", "V 0 0 0\nV 1 0 0\nV 0 1 0\nF 1 2 3\n"
    yield "index_zero", SQUARE + "f 0 1 2\n"
    yield "index_beyond", SQUARE + "f 1 2 5\n"
    yield "index_before", SQUARE + "f -5 1 2\n"
    yield "other_elements", SQUARE + "vp 0 0\np 1 2\nl 1 2 3\nf 1 2 3\nl 3 4\ncstype bezier\ndeg 3\ncurv 0 1 1 2 3 4\nend\nf 1 3 4\n"
    yield "flat_and_not_finite", "v 0 0 0\nv 1 1 1\nv 2 2 2\nv 1 0 0\nv nan 0 0\nv 1e39 0 0\nv 0 -inf 0\nf 1 2 3\nf 1 2 4\nf 2 2 4\nf 1 2 5\nf 1 4 6\nf 4 2 7\nf 3 2 4\n"
    yield "beyond_f64", "v 0 0 0\nv 1e400 0 0\nv -1e999 1 0\nv 1 0 0\nv 0 1 0\nv inf 0 0\nv -nan(ind) 0 0\nf 1 2 4\nf 1 4 5\nf 3 4 5\nf 1 4 6\nf 1 4 7\n"
    yield "sign_behind", SQUARE + "f 1 2 3\nf 1 3 4 \x1a"
    yield "index_huge", SQUARE + "f 1 2 99999999999999999999\n"
    yield "far", "".join("v %.4f %.4f %.4f\n" % (500123.25 + 0.1 * (i % 9), 102.5 + 0.01 * math.sin(i), -4649777 + 0.1 * (i // 9)) for i in range(81)) + "".join(
        "f %d %d %d %d\n" % (i + 1, i + 2, i + 11, i + 10) for i in range(71) if i % 9 < 8)


def parts():
    """A part is a run of faces of one object, group and material."""
    yield "objects", SIX + "o Lamp\ng off\nf 1 2 3\no Chair\ng off\nf 4 5 6\n"
    yield "objects_of_one_name", SIX + "o Cube\nf 1 2 3\no Cube\nf 4 5 6\n"
    yield "names_with_slash", SIX + "g a/b\nusemtl c\nf 1 2 3\ng a\nusemtl b/c\nf 4 5 6\n"
    yield "run_returns", SIX + "g a\nf 1 2 3\ng b\nf 4 5 6\ng a\nf 1 2 4\n"
    yield "run_goes_on", SIX + "g a\nf 1 2 3\ng a\nf 4 5 6\nusemtl m\nusemtl m\nf 1 2 4\nl 1 2\nf 1 2 5\n"
    yield "material_alone", SIX + "usemtl red\nf 1 2 3\nusemtl green\nf 4 5 6\nusemtl red\nf 1 2 4\n"
    yield "empty_parts", SIX + "o a\no b\ng x\nf 1 2 3\ng y\ng z\nusemtl q\nf 4 5 6\no end\n"
    yield "several_groups", SIX + "g a b\nf 1 2 3\ng b a\nf 4 5 6\ng\nf 1 2 4\ng default\nf 1 2 5\n"
    yield "odd_names", SIX + "o 50%/2\ng\ttwo\twords \t\nf 1 2 5\ng a%2Fb/c d\nf 1 2 3\no  é ü \ng\nf 4 5 6\no x\ng " + "é" * 3000 + "\nf 1 2 4\n"
    yield "flat_part", SIX + "g a\nf 1 1 2\ng b\nf 4 5 6\n"


def polygon_texts():
    yield "quad_concave", ring([(0, 0), (2, 0), (0.5, 0.5), (0, 2)])
    yield "quad_concave_elsewhere", ring([(0.5, 0.5), (0, 2), (0, 0), (2, 0)])
    yield "quad_bent", "v 0 0 0\nv 1 0 0\nv 1 1 1\nv 0 1 0\nf 1 2 3 4\nf 4 3 2 1\n"
    yield "star", ring(star(7))
    yield "star_large", ring(star(150))
    yield "star_far", ring(star(7), (5e5, 1e2, -4.6e6))
    yield "comb", ring([(0, 0), (9, 0)] + [p for i in range(8, -1, -1) for p in ((i + 0.75, 3), (i + 0.25, 0.5))])
    yield "corners_in_line", ring([(0, 0), (1, 0), (2, 0), (2, 1), (2, 2), (1, 2), (0, 2), (0, 1)])
    yield "corner_twice", ring([(0, 0), (2, 0), (2, 0), (2, 2), (0, 2)])
    yield "hole_by_a_bridge", ring([(0, 0), (4, 0), (4, 4), (0, 4), (0, 0), (1, 1), (1, 3), (3, 3), (3, 1), (1, 1)])
    yield "corners_almost_one", "".join("v %s 100 %s\n" % p for p in (
        (500000.01, -4600000.3), (500000.02, -4600000.3), (500000.0, -4600000.6), (500000.03, -4600000.6), (500000.01, -4600000.0), (499999.99, -4600000.3))) + (
        "f 1 2 3 4 5 6\nf 6 1 1 2 4\nf 1 4 5 5 2 6\nf 6 5 4 3 2 1\n")
    yield "corners_almost_one_near", "v 0.1 0.2 0.3\nv 0.10000000298 0.2 0.3\nv 0.9 0.2 0.3\nv 0.90000003 0.8 0.3\nv 0.9 0.8000000119 0.3\nv 0.1 0.8 0.3\nf 1 2 3 4 5 6\nf 2 1 3 5 4 6\n"
    yield "corner_beyond", "v 1 2 -3\nv 2 0 0\nv -1.8 2 2\nv 3.5e38 0 -1\nv 0 1 4\nf 1 4 3 2 3\nf 4 1 2 5\nf 1 2 3 5 2\n"
    yield "bow_tie", ring([(0, 0), (2, 2), (2, 0), (0, 2)])
    yield "all_in_line", ring([(0, 0), (1, 1), (2, 2), (3, 3)])
    yield "polygons_among_triangles", SIX + "f 1 2 3\nf 1 2 5 4\nf 4 5 6\ng g\nf 2 3 6 5\nf 1 3 6\nf 1 3 6 4\n"


def write(folder):
    for group, source in (("obj", texts), ("parts", parts), ("polygon", polygon_texts)):
        for name, text in source():
            with open(os.path.join(folder, "%s_%s.obj" % (group, name)), "w", encoding="utf-8", newline="") as file:
                file.write(text)
    # Names are bytes of any encoding: these two are one group each.
    with open(os.path.join(folder, "parts_latin_names.obj"), "wb") as file:
        file.write(SIX.encode() + b"g caf\xe9\nf 1 2 3\ng caf\xe8\nf 4 5 6\n")
