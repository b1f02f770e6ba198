//! The container and its hashes: rules `E01xx` and `E02xx`.

use super::*;

pub(super) fn container() -> Vec<Invalid> {
    let head = |rule, edit: fn(&mut Header)| broken(rule, with_header(plane(), edit));
    let node = |rule, edit: fn(&mut SectionEntry)| broken(rule, with_entry(plane(), SectionKind::NODE, edit));
    let mut text_mode = plane();
    text_mode.splice(4..6, [b'\n']);
    let mut padding = plane();
    *padding.last_mut().unwrap() = 1;
    let mut longer = plane();
    longer.extend([0; 64]);
    let longer = with_header(longer, |h| h.file_len += 64);
    let (header, mut without_geom) = take_apart(&plane());
    without_geom.remove(2);
    let twice = bytes::stored(&mut plane(), SectionKind::META).to_vec();
    vec![
        broken(&rules::E0101, plane()[..200].to_vec()),
        broken(&rules::E0102, text_mode),
        head(&rules::E0103, |h| h.major = 2),
        head(&rules::E0104, |h| (h.minor, h.min_minor) = (bvhc::cache::MINOR + 1, bvhc::cache::MINOR + 1)),
        head(&rules::E0105, |h| h.header_len = 192),
        head(&rules::E0106, |h| h.file_len += 64),
        head(&rules::E0107, |h| h.features_required = 1 << 9),
        head(&rules::E0108, |h| h.section_count = 65_537),
        head(&rules::E0109, |h| h.section_entry_len = 64),
        head(&rules::E0110, |h| h.section_table_off = 320),
        head(&rules::E0111, |h| h.reserved[3] = 1),
        node(&rules::E0112, |e| e.reserved[11] = 1),
        broken(
            &rules::E0113,
            bytes::with_section(&plane(), *b"WARP", section_flags::CRITICAL, b"no reader knows this"),
        ),
        node(&rules::E0114, |e| e.schema = 2),
        node(&rules::E0115, |e| e.codec = 7),
        node(&rules::E0116, |e| e.align_log2 = 5),
        broken(
            &rules::E0117,
            with_entry(plane(), SectionKind::META, |e| {
                e.stored_len += 4096;
                e.raw_len += 4096;
            }),
        ),
        node(&rules::E0118, |e| {
            e.stored_len += 64;
            e.raw_len += 64;
            e.elem_count += 2;
        }),
        broken(&rules::E0119, padding),
        broken(&rules::E0120, longer),
        broken(&rules::E0121, bytes::with_section(&plane(), *b"META", section_flags::COPY_SAFE, &twice)),
        node(&rules::E0122, |e| {
            e.elem_size = 64;
            e.elem_count /= 2;
        }),
        node(&rules::E0123, |e| e.elem_count += 1),
        node(&rules::E0124, |e| e.flags |= section_flags::COPY_SAFE),
        broken(&rules::E0125, put_together(header, without_geom)),
        head(&rules::E0126, |h| h.tree_flags |= 1 << 10),
        Invalid {
            packed: true,
            limits: Limits { max_memory: 1000, ..Limits::default() },
            ..broken(&rules::E0127, valid::packed())
        },
        head(&rules::E0128, |h| h.min_minor = 1),
        broken(
            &rules::E0129,
            with_entry(plane(), SectionKind::META, |e| {
                e.codec = SectionEntry::ZSTD;
                e.raw_len = (1 << 20) + 1;
            }),
        ),
        broken(&rules::W0101, valid::unknown_ancillary()),
    ]
}

pub(super) fn hashes() -> Vec<Invalid> {
    let packed = |rule, bytes| Invalid { packed: true, ..broken(rule, bytes) };
    let mut flipped = plane();
    bytes::stored(&mut flipped, SectionKind::NODE)[5] ^= 0x10;
    let mut header_flipped = plane();
    header_flipped[60] ^= 0x40;
    let mut content = bytes::header(&plane());
    content.content_id[0] ^= 1;
    let mut other_content = plane();
    bytes::set_header(&mut other_content, &content);
    let mut garbled = valid::packed();
    bytes::stored(&mut garbled, SectionKind::TRIS)[8] ^= 1; // the length of the first frame
    let longer = |kind| {
        let (header, mut sections) = take_apart(&plane());
        sections.iter_mut().filter(|(e, _)| e.kind == kind).for_each(|(_, data)| data.push(0));
        put_together(header, sections)
    };
    let mut absolute = plane();
    replace(bytes::stored(&mut absolute, SectionKind::META), b"vector.obj", b"/ector.obj");
    let mut names = file(&valid::parts());
    bytes::stored(&mut names, SectionKind::NAMS)[8] = 200; // where the first name ends
    let mut materials = file(&valid::origins());
    bytes::stored(&mut materials, SectionKind::MATS)[8] = 200;
    vec![
        broken(&rules::E0201, flipped),
        packed(&rules::E0202, with_entry(valid::packed(), SectionKind::TRIS, |e| e.raw_hash[0] ^= 1)),
        broken(&rules::E0203, header_flipped),
        broken(&rules::E0204, sign(other_content)),
        packed(&rules::E0205, refix(garbled)),
        broken(&rules::E0206, longer(SectionKind::META)),
        broken(&rules::E0207, with_header(plane(), |h| h.build_key[0] ^= 1)),
        broken(&rules::E0208, refix(names)),
        broken(&rules::E0209, refix(absolute)),
        broken(&rules::E0210, refix(materials)),
    ]
}
