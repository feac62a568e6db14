//! Words of a text file, one at a time, with their lines.

use std::io::BufRead;

/// Longest word that is read; numbers have some 20 characters.
const WORD_MAX: usize = 80;

/// Words between blanks and line breaks. Memory does not grow with the file.
pub(super) struct Tokens<R> {
    reader: R,
    word: Vec<u8>,
    /// Whether `word` is still to be handed out.
    waiting: bool,
    /// Where reading is, and where the last word began.
    line: u64,
    word_line: u64,
}

impl<R: BufRead> Tokens<R> {
    pub fn new(reader: R) -> Self {
        Self { reader, word: Vec::new(), waiting: false, line: 1, word_line: 1 }
    }

    /// Line of the last word, from 1.
    pub fn word_line(&self) -> u64 {
        self.word_line
    }

    /// The next word, `None` at the end of the file.
    pub fn next(&mut self) -> Result<Option<&str>, String> {
        let found = self.fetch()?;
        self.waiting = false;
        self.text(found)
    }

    /// The word that [`Self::next`] will give.
    pub fn peek(&mut self) -> Result<Option<&str>, String> {
        let found = self.fetch()?;
        self.text(found)
    }

    /// Passes over `count` words without looking at them; how many there were.
    pub fn skip(&mut self, count: u64) -> Result<u64, String> {
        let mut left = count;
        if self.waiting && left > 0 {
            self.waiting = false;
            left -= 1;
        }
        let mut inside = false;
        while left > 0 {
            let bytes = self.reader.fill_buf().map_err(|error| error.to_string())?;
            if bytes.is_empty() {
                left -= u64::from(inside);
                break;
            }
            let mut used = bytes.len();
            for (index, byte) in bytes.iter().enumerate() {
                let blank = byte.is_ascii_whitespace();
                if blank && inside {
                    left -= 1;
                    if left == 0 {
                        used = index;
                        break;
                    }
                }
                if !blank && !inside {
                    self.word_line = self.line;
                }
                inside = !blank;
                self.line += u64::from(*byte == b'\n');
            }
            self.reader.consume(used);
        }
        Ok(count - left)
    }

    /// Makes sure that the next word is in `word`; false at the end of the file.
    fn fetch(&mut self) -> Result<bool, String> {
        if self.waiting {
            return Ok(true);
        }
        self.word.clear();
        loop {
            let bytes = self.reader.fill_buf().map_err(|error| error.to_string())?;
            let blanks =
                if self.word.is_empty() { bytes.iter().take_while(|b| b.is_ascii_whitespace()).count() } else { 0 };
            self.line += bytes[..blanks].iter().filter(|byte| **byte == b'\n').count() as u64;
            if blanks < bytes.len() && self.word.is_empty() {
                self.word_line = self.line;
            }
            let word = bytes[blanks..].iter().take_while(|byte| !byte.is_ascii_whitespace()).count();
            if self.word.len() + word > WORD_MAX {
                return Err(format!("line {} has a word of more than {WORD_MAX} characters", self.word_line));
            }
            self.word.extend_from_slice(&bytes[blanks..blanks + word]);
            let (ended, empty) = (blanks + word < bytes.len(), bytes.is_empty());
            self.reader.consume(blanks + word);
            if empty || (ended && !self.word.is_empty()) {
                self.waiting = !self.word.is_empty();
                return Ok(self.waiting);
            }
        }
    }

    fn text(&self, found: bool) -> Result<Option<&str>, String> {
        let text = std::str::from_utf8(&self.word).map_err(|_| format!("line {} is not text", self.word_line))?;
        Ok(found.then_some(text))
    }
}

#[cfg(test)]
mod tests {
    use std::io::BufReader;

    use super::*;

    #[test]
    fn words_and_lines_are_the_same_whatever_the_buffer() {
        for capacity in 1..20 {
            let text = "  ncols 12\r\n\nab\tcd e\n 123456 \n";
            let mut tokens = Tokens::new(BufReader::with_capacity(capacity, text.as_bytes()));
            assert_eq!(tokens.peek(), Ok(Some("ncols")));
            let mut found = Vec::new();
            while let Some(word) = tokens.next().expect("text") {
                let word = word.to_owned();
                found.push((word, tokens.word_line()));
            }
            let wanted = [("ncols", 1), ("12", 1), ("ab", 3), ("cd", 3), ("e", 3), ("123456", 4)];
            assert_eq!(found, wanted.map(|(word, line)| (word.to_owned(), line)), "{capacity}");
            assert_eq!(tokens.next(), Ok(None));
        }
    }

    #[test]
    fn skipped_words_are_counted() {
        for capacity in 1..12 {
            for peeked in [false, true] {
                let mut tokens = Tokens::new(BufReader::with_capacity(capacity, &b" a b\nc\n\n d e"[..]));
                if peeked {
                    tokens.peek().expect("text");
                }
                assert_eq!(tokens.skip(0), Ok(0));
                assert_eq!(tokens.skip(3), Ok(3));
                assert_eq!(tokens.word_line(), 2, "{capacity}");
                assert_eq!(tokens.next(), Ok(Some("d")));
                assert_eq!(tokens.word_line(), 4);
                assert_eq!(tokens.skip(5), Ok(1));
            }
        }
    }

    #[test]
    fn endless_words_and_other_bytes_are_refused() {
        let endless = vec![b'1'; 1000];
        assert!(Tokens::new(&endless[..]).next().is_err());
        assert!(Tokens::new(&b"\xff\xfe"[..]).next().is_err());
    }
}
