"""Compact trees, SPEC.md 5.7: whether one is its BLAS with fewer nodes, in boxes that hold what theirs hold. Used by bvhc_reader.py."""

import numpy as np


def check(nodes, order, binary, require, name):
    """Hold one compact tree against its BLAS, whose rules were checked; `order` are its numbers in CREF. Returns what `waiting` must be."""
    if len(nodes) == 0:
        return 0
    children, counts = nodes["children"].tolist(), nodes["counts"].tolist()
    inner = check_links(nodes, children, counts, order, require, name)
    below = [0] * len(nodes)  # references below each node; children stand behind their parents
    for i in reversed(range(len(nodes))):
        below[i] = sum(counts[i]) + sum(below[child] for child in inner[i] if child is not None)
    refs = binary_refs(binary)
    boxes = decoded(nodes)
    most, pending = 0, [(0, 0, 0, 0)]  # node, node of the BLAS, first reference, children that wait beside it and above
    while pending:
        i, whole, first, waiting = pending.pop()
        most = max(most, waiting + children[i])
        cut, next_ref, found, stands_for = [whole], int(nodes["first_ref"][i]), [], []
        for lane in range(children[i]):
            child, count = inner[i][lane], counts[i][lane]
            wanted = below[child] if child is not None else count
            while cut and refs[cut[-1]] > wanted and binary["count"][cut[-1]] == 0:
                pair = int(binary["first"][cut.pop()])
                cut += [pair + 1, pair]
            require(cut and refs[cut[-1]] == wanted, "%s: child %d of node %d is no node of the BLAS" % (name, lane, i))
            at = cut.pop()
            stands_for.append(at)
            low, high = boxes[0][i, :, lane], boxes[1][i, :, lane]
            holds = (low <= binary["min"][at]).all() and (high >= binary["max"][at]).all()
            require(holds, "%s: the box of child %d of node %d is too small" % (name, lane, i))
            if child is None:
                require(order[next_ref:next_ref + count] == list(range(first, first + count)), "%s: order of node %d" % (name, i))
                next_ref += count
            else:
                found.append((child, at, first, waiting + children[i] - 1))
            first += wanted
        require(is_least(nodes[i], binary[stands_for]), "%s: the grid of node %d, or a plane on it, is not the least" % (name, i))
        pending += reversed(found)
    return most


def check_links(nodes, children, counts, order, require, name):
    """Rules 1, 3 and 4; for each node and lane the child's record, None for a leaf."""
    firsts = list(zip(nodes["first_node"].tolist(), nodes["first_ref"].tolist()))
    inner, next_node, next_ref, pending = [None] * len(nodes), 1, 0, [0]
    while pending:
        i = pending.pop()
        used = children[i]
        alone = len(nodes) == 1 and used == 1 and counts[i][0] > 0
        require(2 <= used <= 8 or alone, "%s: node %d has %d children" % (name, i, used))
        planes = np.concatenate([nodes[f][i].reshape(3, 8)[:, used:] for f in ("low", "high")])
        require(not planes.any() and not any(counts[i][used:]), "%s: unused lanes of node %d are not zero" % (name, i))
        require(firsts[i] == (next_node, next_ref), "%s: the children of node %d are not the next" % (name, i))
        inner[i] = []
        for count in counts[i][:used]:
            inner[i].append(None if count else next_node)
            next_node, next_ref = next_node + (count == 0), next_ref + count
        require(next_node <= len(nodes), "%s: node %d has children beyond the tree" % (name, i))
        pending += reversed([child for child in inner[i] if child is not None])
    require((next_node, next_ref) == (len(nodes), len(order)), "%s: nodes or references without a parent" % name)
    return inner


def binary_refs(nodes):
    """References below each node of a BLAS."""
    first, refs = nodes["first"].tolist(), nodes["count"].tolist()
    for i in reversed(range(len(nodes))):
        if i != 1 and refs[i] == 0:
            refs[i] = refs[first[i]] + refs[first[i] + 1]
    return refs


def is_least(node, boxes):
    """Rule 6: the grid that a node must have for these boxes, plane by plane from the definition."""
    numbers = np.arange(256, dtype=np.float32)
    for axis in range(3):
        least, greatest = boxes["min"][:, axis].min(), boxes["max"][:, axis].max()
        with np.errstate(all="ignore"):
            steps = (np.arange(255, dtype=np.uint32) << np.uint32(23)).view(np.float32)
            exponent = int(np.argmax(np.append(least + np.float32(255) * steps >= greatest, True)))
            planes = least + numbers * (np.uint32(exponent) << np.uint32(23)).view(np.float32)
        if node["origin"][axis] != least or node["exponents"][axis] != exponent:
            return False
        for lane, box in enumerate(boxes):
            low = np.flatnonzero(planes <= box["min"][axis])[-1] if exponent else 0
            high = np.argmax(planes >= box["max"][axis]) if exponent else 0
            if (node["low"].reshape(3, 8)[axis, lane], node["high"].reshape(3, 8)[axis, lane]) != (low, high):
                return False
    return True


def decoded(nodes):
    """The near and the far planes, [node, axis, lane], as f32 arithmetic gives them."""
    bits = nodes["exponents"].astype(np.uint32) << np.uint32(23)
    origin, step = nodes["origin"][:, :, None], bits.view(np.float32)[:, :, None]
    with np.errstate(all="ignore"):
        return tuple(origin + nodes[f].reshape(-1, 3, 8).astype(np.float32) * step for f in ("low", "high"))
