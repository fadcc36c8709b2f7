//! Changes to an input, as people, editors and disks make them.

/// A generator with a fixed sequence (splitmix64).
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Random {
        Random(seed)
    }

    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub fn below(&mut self, n: usize) -> usize {
        (self.next() % n.max(1) as u64) as usize
    }
}

/// Numbers at which programs break.
const NUMBERS: [&str; 30] = [
    "0",
    "-0.0",
    "1",
    "-1",
    "2",
    "3",
    "nan",
    "inf",
    "-inf",
    "1e308",
    "-1e308",
    "1e-308",
    "5e-324",
    "1e-30",
    "1e30",
    "1e17",
    "0.1",
    "0.5",
    "1e3",
    "4294967295",
    "4294967296",
    "2147483648",
    "9223372036854775807",
    "18446744073709551615",
    "18446744073709551616",
    "1000000000000",
    "1.0000000000000002",
    "0x10",
    "1d5",
    "1_000",
];

/// Characters that mean something, or cannot be.
const MARKS: &[u8] = b" \n\t,;=[]{}\"#%-.e0\0\xff";

/// One of the corpus with one to four changes.
pub fn mutated(corpus: &[Vec<u8>], random: &mut Random) -> Vec<u8> {
    let mut bytes = corpus[random.below(corpus.len())].clone();
    for _ in 0..1 + random.below(4) {
        change(&mut bytes, corpus, random);
    }
    bytes
}

fn change(bytes: &mut Vec<u8>, corpus: &[Vec<u8>], random: &mut Random) {
    if bytes.is_empty() {
        bytes.push(random.next() as u8);
    }
    match random.below(16) {
        0 => bytes.truncate(random.below(bytes.len())),
        1 => {
            let at = random.below(bytes.len());
            bytes[at] ^= 1 << random.below(8);
        }
        2 => {
            let at = random.below(bytes.len());
            bytes[at] = random.next() as u8;
        }
        3 => {
            let at = random.below(bytes.len() + 1);
            bytes.insert(at, MARKS[random.below(MARKS.len())]);
        }
        4 => {
            bytes.remove(random.below(bytes.len()));
        }
        5 => swap_words(bytes, random),
        6 => copy_word(bytes, random),
        7..=10 => replace_number(bytes, random),
        11 => double_line(bytes, random),
        12 => remove_line(bytes, random),
        13 => scale_number(bytes, random),
        14 => {
            // The end of another input.
            let other = &corpus[random.below(corpus.len())];
            bytes.truncate(random.below(bytes.len()));
            bytes.extend_from_slice(&other[random.below(other.len())..]);
        }
        _ => {
            // A piece twice.
            let (a, b) = (random.below(bytes.len()), random.below(bytes.len()));
            let piece = bytes[a.min(b)..a.max(b).min(a.min(b) + 64)].to_vec();
            let at = random.below(bytes.len());
            bytes.splice(at..at, piece);
        }
    }
}

/// Places of the words: what blanks, commas, brackets and equals signs separate.
fn words(bytes: &[u8]) -> Vec<(usize, usize)> {
    let is_between = |b: &u8| b.is_ascii_whitespace() || b",;=[]{}()\"".contains(b);
    let (mut found, mut start) = (vec![], 0);
    for (i, b) in bytes.iter().chain(b" ").enumerate() {
        if is_between(b) {
            if i > start {
                found.push((start, i));
            }
            start = i + 1;
        }
    }
    found
}

fn numbers(bytes: &[u8]) -> Vec<(usize, usize)> {
    let is_number = |&(a, b): &(usize, usize)| {
        std::str::from_utf8(&bytes[a..b]).is_ok_and(|w| w.parse::<f64>().is_ok())
    };
    words(bytes).into_iter().filter(is_number).collect()
}

fn pick<T: Copy>(from: &[T], random: &mut Random) -> Option<T> {
    from.get(random.below(from.len())).copied()
}

fn replace_number(bytes: &mut Vec<u8>, random: &mut Random) {
    let Some((a, b)) = pick(&numbers(bytes), random) else { return };
    bytes.splice(a..b, NUMBERS[random.below(NUMBERS.len())].bytes());
}

/// Another sign, a power of ten, or the last digit.
fn scale_number(bytes: &mut Vec<u8>, random: &mut Random) {
    let Some((a, b)) = pick(&numbers(bytes), random) else { return };
    let value: f64 = std::str::from_utf8(&bytes[a..b]).unwrap().parse().unwrap();
    let other = match random.below(4) {
        0 => -value,
        1 => value * 10f64.powi(random.below(21) as i32 - 10),
        2 => f64::from_bits(value.to_bits().wrapping_add(random.next() % 3).wrapping_sub(1)),
        _ => value * (0.5 + random.below(1000) as f64 / 1000.0),
    };
    bytes.splice(a..b, format!("{other:?}").bytes());
}

fn swap_words(bytes: &mut Vec<u8>, random: &mut Random) {
    let words = words(bytes);
    let (Some(one), Some(other)) = (pick(&words, random), pick(&words, random)) else { return };
    let (first, second) = (one.min(other), one.max(other));
    if first == second {
        return;
    }
    let (early, late) = (bytes[first.0..first.1].to_vec(), bytes[second.0..second.1].to_vec());
    bytes.splice(second.0..second.1, early);
    bytes.splice(first.0..first.1, late);
}

fn copy_word(bytes: &mut Vec<u8>, random: &mut Random) {
    let words = words(bytes);
    let (Some(one), Some(other)) = (pick(&words, random), pick(&words, random)) else { return };
    let copy = bytes[one.0..one.1].to_vec();
    bytes.splice(other.0..other.1, copy);
}

fn line(bytes: &[u8], random: &mut Random) -> (usize, usize) {
    let at = random.below(bytes.len());
    let start = bytes[..at].iter().rposition(|&b| b == b'\n').map_or(0, |k| k + 1);
    let end = bytes[at..].iter().position(|&b| b == b'\n').map_or(bytes.len(), |k| at + k + 1);
    (start, end)
}

fn double_line(bytes: &mut Vec<u8>, random: &mut Random) {
    let (a, b) = line(bytes, random);
    let copy = bytes[a..b].to_vec();
    bytes.splice(b..b, copy);
}

fn remove_line(bytes: &mut Vec<u8>, random: &mut Random) {
    let (a, b) = line(bytes, random);
    bytes.drain(a..b);
}
