//! Transliteration to ASCII for formats that allow no other characters: accents, Greek letters and signs.
//!
//! Latin letters are replaced as in passports (ICAO Doc 9303, part 3): ä by ae, ß by ss, å by aa. AutoCAD R12 drawings
//! hold no other characters; escapes for them exist only in text of later releases.

/// Combining diaeresis, which follows its letter.
const DIAERESIS: char = '\u{308}';
/// Other combining accents, which follow their letters.
const ACCENTS: std::ops::RangeInclusive<char> = '\u{300}'..='\u{36f}';

/// Groups of letters and signs, parted by blanks: a plain one, and those that differ from it by an accent or a stroke.
const ACCENTED: &str = "aàáâãāăą cçćĉċč dďđð eèéêëēĕėęě gĝğġģ hĥħ iìíîïĩīĭįı jĵ kķ lĺļľŀł nñńņňŉ oòóôõōŏő rŕŗř sśŝşšș tţťŧț uùúûũūŭůűų \
    wŵ yýÿŷ zźżž -\u{2010}\u{2011}–—\u{2212} '‘’‚′ \"“”„″«»";
/// Letters and signs with their spellings, in which `_` is a blank; capitals are spelt accordingly.
const SPELLINGS: &str = "ä=ae ö=oe ü=ue ß=ss å=aa æ=ae ø=oe œ=oe þ=th ĳ=ij ŋ=ng ĸ=q ſ=s İ=I µ=u α=alpha β=beta γ=gamma δ=delta ε=epsilon \
    ζ=zeta η=eta θ=theta ι=iota κ=kappa λ=lambda μ=u ν=nu ξ=xi ο=omicron π=pi ρ=rho σ=sigma ς=sigma τ=tau υ=upsilon \
    φ=phi χ=chi ψ=psi ω=omega °=_deg ±=+- ×=x ·=. ÷=/ …=... ≤=<= ≥=>= ≈=~ ¼=1/4 ½=1/2 ¾=3/4 €=EUR ©=(c) ®=(R) ™=(TM) \
    Ω=Ohm ⌀=diameter_ ∅=diameter_ →=-> †=+";

/// Transliterates one line of text to printable ASCII; letters without a replacement become question marks.
pub(crate) fn ascii(text: &str) -> String {
    let mut plain = String::new();
    for letter in text.chars() {
        match letter {
            ' '..='~' => plain.push(letter),
            DIAERESIS => plain.push_str(match plain.chars().next_back() {
                Some('a' | 'o' | 'u' | 'A' | 'O' | 'U') => "e",
                _ => "",
            }),
            _ if ACCENTS.contains(&letter) => {}
            '\u{a0}' | '\u{2009}' | '\u{202f}' => plain.push(' '),
            _ => push(letter, &mut plain),
        }
    }
    plain
}

/// Appends the replacement of a letter that is not ASCII.
fn push(letter: char, plain: &mut String) {
    let digit = match letter {
        '²' => Some('2'),
        '³' => Some('3'),
        '¹' => Some('1'),
        '\u{2070}' | '\u{2074}'..='\u{2079}' => char::from_digit(u32::from(letter) - 0x2070, 10),
        '\u{2080}'..='\u{2089}' => char::from_digit(u32::from(letter) - 0x2080, 10),
        _ => None,
    };
    let of = |wanted: char| {
        let spelt = SPELLINGS.split(' ').filter_map(|pair| pair.split_once('=')).find(|(of, _)| of.contains(wanted));
        let plain = || ACCENTED.split(' ').find(|all| all.contains(wanted)).and_then(|all| all.chars().next());
        spelt.map(|(_, spelt)| spelt.replace('_', " ")).or_else(|| plain().map(String::from))
    };
    let small = letter.to_lowercase().next().filter(|small| *small != letter);
    let capital = || {
        let small = of(small?)?;
        let mut letters = small.chars();
        letters.next().map(|first| first.to_ascii_uppercase().to_string() + letters.as_str())
    };
    match digit.map(String::from).or_else(|| of(letter)).or_else(capital) {
        Some(found) => plain.push_str(&found),
        None => plain.push('?'),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stay_readable() {
        for (text, plain) in [
            ("Größe der Mühle, Öl", "Groesse der Muehle, Oel"),
            ("Ärmel Übung Straße", "Aermel Uebung Strasse"),
            ("polymère, Łódź, Škoda, Ñandú", "polymere, Lodz, Skoda, Nandu"),
            ("Ærø, Ångström", "Aeroe, Aangstroem"),
            ("20 µm, 20 μm at 45°", "20 um, 20 um at 45 deg"),
            ("130 ± 8 µm × 2 – “wide” … m², 10³, H₂O", "130 +- 8 um x 2 - \"wide\" ... m2, 103, H2O"),
            ("φ = 30°, Δ, Ω", "phi = 30 deg, Delta, Ohm"),
            // File systems that decompose accents write them so.
            ("Mu\u{308}hle, Sche\u{301}ma, nai\u{308}f", "Muehle, Schema, naif"),
            ("plain (1) \"text\"", "plain (1) \"text\""),
            ("表面\n\t\u{7f}", "?????"),
        ] {
            assert_eq!(ascii(text), plain, "{text}");
        }
    }

    #[test]
    fn every_character_becomes_printable_ascii_of_one_line() {
        for letter in (0..=0x2fff).filter_map(char::from_u32) {
            let plain = ascii(&letter.to_string());
            assert!(plain.bytes().all(|byte| (b' '..=b'~').contains(&byte)), "{letter:?}: {plain:?}");
        }
        // All letters of Latin-1 and Latin Extended-A have replacements.
        for letter in ('\u{c0}'..='\u{17f}').filter(|letter| letter.is_alphabetic()) {
            let plain = ascii(&letter.to_string());
            assert!(!plain.is_empty() && plain.chars().all(|plain| plain.is_ascii_alphabetic()), "{letter}: {plain}");
        }
    }
}
