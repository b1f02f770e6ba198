meta:
  id: bvhc
  title: Cached bounding volume hierarchies over triangles
  file-extension: bvhc
  license: MIT OR Apache-2.0
  ks-version: 0.11
  endian: le
doc: |
  The .bvhc file, version 1.4, as a Kaitai Struct description. SPEC.md beside this file is the law; this description covers the
  container (header, section table), every record type, META, NAMS and MATS, and the frame lists of compressed sections, whose
  frames it hands out undecoded: Zstandard frames, which of codec delta hold differences from what is predicted. It checks the magic and the few sizes that it needs itself, not the other rules.
doc-ref: format-spec/SPEC.md

seq:
  - id: header
    type: header
  - id: header_tail
    size: header.header_len - 256
    doc: What a later minor version added.

instances:
  sections:
    pos: header.section_table_off
    type: section
    size: header.section_entry_len
    repeat: expr
    repeat-expr: header.section_count

enums:
  kind:
    0x45444f4e: nodes  # NODE
    0x53495254: triangles  # TRIS
    0x4d4f4547: geoms  # GEOM
    0x53414c42: blases  # BLAS
    0x444f4e54: tlas_nodes  # TNOD
    0x54534e49: instances  # INST
    0x574f5243: compact_rows  # CROW
    0x444f4e43: compact_nodes  # CNOD
    0x46455243: compact_references  # CREF
    0x574f524f: turns  # OROW
    0x444f4e4f: turned_nodes  # ONOD
    0x54524556: vertices  # VERT
    0x45444953: sides  # SIDE
    0x534d414e: names  # NAMS
    0x5354414d: materials  # MATS
    0x4154454d: meta  # META
    0x4f504f54: topologies  # TOPO
    0x58495254: indexed_triangles  # TRIX
    0x45534f50: poses  # POSE
    0x534f5056: positions  # VPOS
    0x4d415246: frames  # FRAM
  codec:
    0: raw
    1: zstd
    2: delta
  layout:
    0: unknown
    1: zstd  # frames, which codec delta has as well
    2: nodes
    3: triangles
    4: geoms
    5: blases
    6: instances
    7: names
    8: meta
    9: vertices
    10: sides
    11: topologies
    12: indexed_triangles
    13: poses
    14: positions
    15: frames
    16: compact_rows
    17: compact_nodes
    18: compact_references
    19: turns

types:
  header:
    seq:
      - id: magic
        contents: [0x89, BVH, 0x0d, 0x0a, 0x1a, 0x0a]
      - id: major
        type: u2
        valid: 1
      - id: minor
        type: u2
      - id: min_minor
        type: u2
      - id: header_len
        type: u2
        valid:
          min: 256
      - id: file_len
        type: u8
      - id: features_required
        type: u8
      - id: features_optional
        type: u8
      - id: section_count
        type: u4
        valid:
          max: 65536
      - id: section_entry_len
        type: u4
        valid: 128
      - id: section_table_off
        type: u8
      - id: tree_flags
        type: u4
      - id: builder_id
        type: u4
        doc: Information, 0 for most methods; META names the method.
      - id: file_id
        size: 32
      - id: content_id
        size: 32
      - id: build_key
        size: 32
      - id: prim_count
        type: u8
      - id: ref_count
        type: u8
      - id: node_count
        type: u8
      - id: blas_count
        type: u4
      - id: instance_count
        type: u4
      - id: frame_count
        type: u4
      - id: max_depth
        type: u4
      - id: scene_min
        type: point
      - id: scene_max
        type: point
      - id: reserved
        size: 32
    instances:
      is_refittable:
        value: (tree_flags & 1) != 0
      has_dup_refs:
        value: (tree_flags & 2) != 0
      is_canonical_dfs:
        value: (tree_flags & 4) != 0
      is_sequence:
        value: (tree_flags & 8) != 0
      is_two_level:
        value: (tree_flags & 16) != 0

  section:
    seq:
      - id: kind
        type: u4
        enum: kind
        doc: Four ASCII bytes, read as a number.
      - id: ordinal
        type: u4
      - id: flags
        type: u4
      - id: schema
        type: u2
      - id: codec
        type: u1
        enum: codec
      - id: align_log2
        type: u1
      - id: offset
        type: u8
      - id: stored_len
        type: u8
      - id: raw_len
        type: u8
      - id: elem_count
        type: u8
      - id: elem_size
        type: u4
      - id: reserved
        size: 12
      - id: raw_hash
        size: 32
      - id: stored_hash
        size: 32
    instances:
      is_critical:
        value: (flags & 1) != 0
      is_copy_safe:
        value: (flags & 2) != 0
      is_content:
        value: (flags & 4) != 0
      is_delta:
        value: |
          codec == codec::delta and schema == 1 and
          (kind == kind::nodes or kind == kind::indexed_triangles or kind == kind::positions)
        doc: Whether it holds differences, as these types of a sequence may.
      layout:
        value: |
          codec == codec::zstd or is_delta ? layout::zstd :
          codec != codec::raw or schema != 1 ? layout::unknown :
          kind == kind::nodes or kind == kind::tlas_nodes ? layout::nodes :
          kind == kind::triangles ? layout::triangles :
          kind == kind::geoms ? layout::geoms :
          kind == kind::blases ? layout::blases :
          kind == kind::instances ? layout::instances :
          kind == kind::vertices ? layout::vertices :
          kind == kind::sides ? layout::sides :
          kind == kind::topologies ? layout::topologies :
          kind == kind::indexed_triangles ? layout::indexed_triangles :
          kind == kind::poses ? layout::poses :
          kind == kind::positions ? layout::positions :
          kind == kind::frames ? layout::frames :
          kind == kind::compact_rows ? layout::compact_rows :
          kind == kind::compact_nodes ? layout::compact_nodes :
          kind == kind::compact_references ? layout::compact_references :
          kind == kind::turns ? layout::turns :
          kind == kind::turned_nodes ? layout::nodes :
          kind == kind::names or kind == kind::materials ? layout::names :
          kind == kind::meta ? layout::meta : layout::unknown
      body:
        io: _root._io
        pos: offset
        size: stored_len
        type:
          switch-on: layout
          cases:
            layout::zstd: zstd_frames
            layout::nodes: nodes(elem_count)
            layout::triangles: triangles(elem_count)
            layout::geoms: geoms(elem_count)
            layout::blases: blases(elem_count)
            layout::instances: instance_table(elem_count)
            layout::vertices: vertices(elem_count)
            layout::sides: sides(elem_count)
            layout::topologies: topologies(elem_count)
            layout::indexed_triangles: indexed_triangles(elem_count)
            layout::poses: poses(elem_count)
            layout::positions: positions(elem_count)
            layout::frames: frames(elem_count)
            layout::compact_rows: compact_rows(elem_count)
            layout::compact_nodes: compact_nodes(elem_count)
            layout::compact_references: compact_references(elem_count)
            layout::turns: turns(elem_count)
            layout::names: names
            layout::meta: provenance

  zstd_frames:
    doc: |
      Blocks of 1 MiB, the last one shorter, each an independent Zstandard frame: of the decoded bytes, or with codec delta of packed
      bytes, whose length follows from the rows of TOPO and POSE (SPEC.md, section 8.1).
    seq:
      - id: num_frames
        type: u4
      - id: zero
        type: u4
        valid: 0
      - id: lens
        type: u4
        repeat: expr
        repeat-expr: num_frames
      - id: frames
        size: lens[_index]
        repeat: expr
        repeat-expr: num_frames

  nodes:
    params:
      - id: num
        type: u8
    seq:
      - id: rows
        type: node
        repeat: expr
        repeat-expr: num
  triangles:
    params:
      - id: num
        type: u8
    seq:
      - id: rows
        type: triangle
        repeat: expr
        repeat-expr: num
  geoms:
    params:
      - id: num
        type: u8
    seq:
      - id: rows
        type: geom
        repeat: expr
        repeat-expr: num
  blases:
    params:
      - id: num
        type: u8
    seq:
      - id: rows
        type: blas
        repeat: expr
        repeat-expr: num
  instance_table:
    params:
      - id: num
        type: u8
    seq:
      - id: rows
        type: instance
        repeat: expr
        repeat-expr: num

  vertices:
    params:
      - id: num
        type: u8
    seq:
      - id: rows
        type: vertex_numbers
        repeat: expr
        repeat-expr: num
  sides:
    params:
      - id: num
        type: u8
    seq:
      - id: rows
        type: side
        repeat: expr
        repeat-expr: num

  topologies:
    params:
      - id: num
        type: u8
    seq:
      - id: rows
        type: topology
        repeat: expr
        repeat-expr: num
  indexed_triangles:
    params:
      - id: num
        type: u8
    seq:
      - id: rows
        type: indexed_triangle
        repeat: expr
        repeat-expr: num
  poses:
    params:
      - id: num
        type: u8
    seq:
      - id: rows
        type: pose
        repeat: expr
        repeat-expr: num
  positions:
    params:
      - id: num
        type: u8
    seq:
      - id: rows
        type: point
        repeat: expr
        repeat-expr: num
  frames:
    params:
      - id: num
        type: u8
    seq:
      - id: rows
        type: frame
        repeat: expr
        repeat-expr: num

  compact_rows:
    params:
      - id: num
        type: u8
    seq:
      - id: rows
        type: compact_row
        repeat: expr
        repeat-expr: num
  compact_nodes:
    params:
      - id: num
        type: u8
    seq:
      - id: rows
        type: compact_node
        repeat: expr
        repeat-expr: num
  compact_references:
    params:
      - id: num
        type: u8
    seq:
      - id: rows
        type: compact_reference
        repeat: expr
        repeat-expr: num
  turns:
    params:
      - id: num
        type: u8
    seq:
      - id: rows
        type: turn
        repeat: expr
        repeat-expr: num

  node:
    seq:
      - id: min
        type: point
      - id: first
        type: u4
        doc: Of an inner node, the first of its two children; of a leaf, its first reference.
      - id: max
        type: point
      - id: count
        type: u4
        doc: References of a leaf; 0 for an inner node.
    instances:
      is_leaf:
        value: count != 0
  triangle:
    seq:
      - id: v0
        type: point
      - id: prim
        type: u4
      - id: v1
        type: point
      - id: geom
        type: u4
      - id: v2
        type: point
      - id: flags
        type: u4
    instances:
      is_duplicated:
        value: (flags & 1) != 0
  geom:
    seq:
      - id: source_mesh
        type: u4
      - id: source_part
        type: u4
      - id: baked_node
        type: u4
      - id: blas
        type: u4
      - id: first_prim
        type: u4
      - id: prim_count
        type: u4
      - id: kept_count
        type: u4
      - id: reserved
        type: u4
      - id: name_hash
        size: 32
  blas:
    seq:
      - id: min
        type: point
      - id: node_count
        type: u4
      - id: max
        type: point
      - id: ref_count
        type: u4
      - id: node_offset
        type: u8
      - id: ref_offset
        type: u8
      - id: prim_count
        type: u4
      - id: max_depth
        type: u4
      - id: sah
        type: f4
      - id: flags
        type: u4
  instance:
    seq:
      - id: object_to_world
        type: f4
        repeat: expr
        repeat-expr: 12
      - id: world_to_object
        type: f4
        repeat: expr
        repeat-expr: 12
      - id: blas
        type: u4
      - id: id
        type: u4
      - id: mask
        type: u4
      - id: flags
        type: u4
      - id: node
        type: u4
      - id: reserved
        size: 12
    instances:
      is_mirrored:
        value: (flags & 1) != 0

  vertex_numbers:
    doc: Which vertices of the source a triangle has, in the order of its corners.
    seq:
      - id: v0
        type: u4
      - id: v1
        type: u4
      - id: v2
        type: u4
  side:
    seq:
      - id: flags
        type: u4
    instances:
      is_mirrored:
        value: (flags & 1) != 0

  topology:
    doc: What the poses of a tree share.
    seq:
      - id: ref_offset
        type: u8
      - id: ref_count
        type: u4
      - id: node_count
        type: u4
      - id: vertex_count
        type: u4
      - id: prim_count
        type: u4
      - id: max_depth
        type: u4
      - id: flags
        type: u4
      - id: reserved
        size: 32
  indexed_triangle:
    doc: A triangle whose corners are vertices of a pose.
    seq:
      - id: corners
        type: u4
        repeat: expr
        repeat-expr: 3
      - id: prim
        type: u4
      - id: geom
        type: u4
      - id: flags
        type: u4
    instances:
      is_duplicated:
        value: (flags & 1) != 0
  pose:
    doc: A topology at one moment; its records are in the sections NODE and VPOS with the number `block`.
    seq:
      - id: min
        type: point
      - id: topology
        type: u4
      - id: max
        type: point
      - id: block
        type: u4
      - id: node_offset
        type: u8
      - id: vertex_offset
        type: u8
      - id: sah
        type: f4
      - id: flags
        type: u4
      - id: reserved
        size: 8
    instances:
      is_key:
        value: (flags & 1) != 0
  frame:
    doc: What the sections TNOD and INST with the number `placement` show.
    seq:
      - id: number
        type: s4
      - id: placement
        type: u4
      - id: time
        type: f4
      - id: flags
        type: u4
      - id: reserved
        size: 16
    instances:
      is_timed:
        value: (flags & 1) != 0
      is_held:
        value: (flags & 2) != 0

  compact_row:
    doc: A compact tree; its records are in the section CNOD.
    seq:
      - id: node_offset
        type: u8
      - id: node_count
        type: u4
      - id: waiting
        type: u4
  compact_node:
    doc: Up to eight children, with boxes on a grid of the node's own.
    seq:
      - id: origin
        type: point
      - id: exponents
        type: u1
        repeat: expr
        repeat-expr: 3
      - id: children
        type: u1
      - id: first_node
        type: u4
      - id: first_ref
        type: u4
      - id: counts
        type: u1
        repeat: expr
        repeat-expr: 8
      - id: low
        type: u1
        repeat: expr
        repeat-expr: 24
        doc: For each axis, and in it for each lane.
      - id: high
        type: u1
        repeat: expr
        repeat-expr: 24
  compact_reference:
    seq:
      - id: triangle
        type: u4
        doc: Counted from the tree's first record of TRIS.
  turn:
    doc: A turned subtree; its records are in the section ONOD.
    seq:
      - id: axes
        type: f4
        repeat: expr
        repeat-expr: 9
        doc: The axes x, y and z, three numbers each.
      - id: first
        type: u4
      - id: end
        type: u4
      - id: node_offset
        type: u4
      - id: reserved
        size: 16

  point:
    seq:
      - id: x
        type: f4
      - id: y
        type: f4
      - id: z
        type: f4

  names:
    seq:
      - id: num
        type: u4
      - id: len_text
        type: u4
      - id: ends
        type: u4
        repeat: expr
        repeat-expr: num
      - id: text
        size: len_text
    instances:
      rows:
        type: name(_index)
        repeat: expr
        repeat-expr: num
  name:
    params:
      - id: index
        type: u4
    instances:
      start:
        value: 'index == 0 ? 0 : _parent.ends[index - 1]'
      text:
        io: _parent._io
        pos: 8 + 4 * _parent.num + start
        size: _parent.ends[index] - start
        type: str
        encoding: UTF-8

  provenance:
    seq:
      - id: tool
        type: text
      - id: tool_version
        type: text
      - id: method
        type: text
      - id: builder_revision
        type: u4
      - id: num_options
        type: u8
      - id: options
        type: option
        repeat: expr
        repeat-expr: num_options
      - id: num_inputs
        type: u8
      - id: inputs
        type: input
        repeat: expr
        repeat-expr: num_inputs
      - id: num_read_counts
        type: u8
      - id: read_counts
        type: read_count
        repeat: expr
        repeat-expr: num_read_counts
      - id: num_notes
        type: u8
      - id: notes
        type: text
        repeat: expr
        repeat-expr: num_notes
  option:
    seq:
      - id: name
        type: text
      - id: value
        type: text
  input:
    seq:
      - id: role
        type: u4
      - id: name
        type: text
      - id: len
        type: u8
      - id: blake3
        size: 32
  read_count:
    seq:
      - id: name
        type: text
      - id: count
        type: u8
  text:
    seq:
      - id: len
        type: u8
        valid:
          max: 4096
      - id: value
        size: len
        type: str
        encoding: UTF-8
