//! Data URIs (RFC 2397): `data:[media type][;parameters][;base64],content`.

use super::reference::is_scheme;
use base64::Engine;
use percent_encoding::percent_decode_str;
use std::borrow::Cow;

/// What follows `data:`, in any case and behind white space, which browsers leave out; `None` where the URI has another scheme or none.
pub(super) fn strip_scheme(uri: &str) -> Option<&str> {
    let (scheme, rest) = uri.trim_ascii_start().split_once(':')?;
    is_scheme(scheme).then_some(rest).filter(|_| scheme.eq_ignore_ascii_case("data"))
}

/// The bytes of a data URI, `data` being what follows `data:`. The error says what is wrong and cites nothing of the content.
///
/// The media type and its parameters may be absent and do not matter. Content is percent-decoded, a fragment behind `#` is none of it, and in base64
/// white space, absent padding and set bits behind the end are let pass, as browsers do.
pub(super) fn decode(data: &str) -> Result<Vec<u8>, String> {
    let data = data.split_once('#').map_or(data, |(before, _)| before);
    let Some((kind, content)) = data.split_once(',') else {
        return Err("has no comma before its data".into());
    };
    let content: Cow<[u8]> = percent_decode_str(content).into();
    let last = kind.rsplit_once(';').map(|(_, last)| last.trim_ascii());
    if !last.is_some_and(|last| last.eq_ignore_ascii_case("base64")) {
        return Ok(content.into_owned());
    }
    let is_spaced = content.iter().any(u8::is_ascii_whitespace);
    let text = if is_spaced { content.iter().copied().filter(|b| !b.is_ascii_whitespace()).collect() } else { content };
    LENIENT_BASE64.decode(&text).map_err(|e| match e {
        base64::DecodeError::InvalidByte(at, _) => {
            format!("is not base64: byte {at} of its data is none of the alphabet")
        }
        _ => format!("is not base64: its data have a length of {}", text.len()),
    })
}

/// Standard alphabet; padding and unused last bits may be as they come.
const LENIENT_BASE64: base64::engine::GeneralPurpose = base64::engine::GeneralPurpose::new(
    &base64::alphabet::STANDARD,
    base64::engine::GeneralPurposeConfig::new()
        .with_decode_padding_mode(base64::engine::DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true),
);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_form_of_the_rfc_is_read() {
        for uri in [
            "data:application/octet-stream;base64,aGk+",
            "DATA:application/gltf-buffer;BASE64,aGk%2B",
            "data:text/plain;charset=utf-8;base64,aG k+\n",
            "data:;base64,aGk+",
            "data:; base64,aGk+#base64,",
            "data:,hi%3e",
            "data:text/plain;charset=US-ASCII,hi%3E",
            "data:text/plain;base64;x=y,hi>",
        ] {
            assert_eq!(decode(strip_scheme(uri).unwrap()).unwrap(), b"hi>", "{uri}");
        }
        assert_eq!(decode(";base64,aGk").unwrap(), b"hi");
        assert_eq!(decode(";base64,aA==").unwrap(), b"h");
        assert_eq!(decode(";base64,").unwrap(), b"");
        assert!(
            strip_scheme("data").is_none() && strip_scheme("data.bin").is_none() && strip_scheme("da ta:,").is_none()
        );
    }

    #[test]
    fn errors_cite_nothing_of_the_content() {
        for (data, why) in
            [("secret", "no comma"), (";base64,secret!secret", "byte 6"), (";base64,secre", "a length of 5")]
        {
            let error = decode(data).unwrap_err();
            assert!(error.contains(why) && !error.contains("secre"), "{error}");
        }
    }
}
