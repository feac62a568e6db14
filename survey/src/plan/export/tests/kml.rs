//! `plan.kml`.

use super::{grid, text};

/// Every tag is closed by its own name, in order; nothing stands unescaped between them.
fn is_well_formed(xml: &str) -> bool {
    let mut open = Vec::new();
    for part in xml.split('<').skip(1) {
        let Some((tag, after)) = part.split_once('>') else { return false };
        if after
            .split('&')
            .skip(1)
            .any(|rest| !["amp;", "lt;", "gt;", "quot;"].iter().any(|name| rest.starts_with(name)))
        {
            return false;
        }
        match tag.strip_prefix('/') {
            Some(name) if open.pop() != Some(name) => return false,
            Some(_) => {}
            None if tag.starts_with('?') || tag.ends_with('/') => {}
            None => open.extend(tag.split(' ').next()),
        }
    }
    open.is_empty()
}

#[test]
fn kml_is_well_formed_and_has_every_photo() {
    assert!(
        is_well_formed("<a b=\"1\"><c>&amp;</c></a>")
            && !is_well_formed("<a><b></a></b>")
            && !is_well_formed("<a>&</a>")
    );
    grid().outputs(|outputs| {
        let kml = text(outputs, "plan.kml");
        assert!(is_well_formed(&kml), "{kml}");
        assert!(kml.contains("a&lt;b&amp;c.tif") && !kml.contains("folder"));
        assert_eq!(kml.matches("<Point>").count(), outputs.file.photo_count);
        assert_eq!(kml.matches("<LineString>").count(), outputs.file.strips.len());
        let photo = &outputs.file.strips[0].photos[0];
        let (lat, lon) = (photo.lat.expect("known"), photo.lon.expect("known"));
        let rounded = |deg: f64| (deg * 1e7).round() / 1e7;
        let coordinates = format!("<coordinates>{},{},{:.2}</coordinates>", rounded(lon), rounded(lat), photo.z);
        assert!(kml.contains(&coordinates), "{coordinates}");
    });
}
