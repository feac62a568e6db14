//! Whether fixes come, and why not, and whether satellite navigation is where they are: what the pilot of an armed vehicle is told.

use plumbline_core::pipeline::Refusal;
use plumbline_core::tile::Geographic;

/// Seconds without an accepted fix after which they count as lost: an autopilot's filter that has nothing else drifts some ten
/// metres by then.
const LOST_S: u16 = 10;
/// So many fixes within [`LOST_S`] are trusted: one may be chance, and a second that of the same ground.
const TRUSTED: usize = 3;
/// Refusals that are counted, by their codes; the first place is for none.
const REFUSALS: usize = 32;

/// What the pilot is to be told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum News {
    /// No fix for so many seconds, and the refusal that was most frequent meanwhile, where there were frames at all.
    Lost(u16, Option<Refusal>),
    /// They come again.
    Back,
    /// The frame that they are sent in begins elsewhere now.
    Moved,
    /// Satellite navigation is so many metres off where the map has the vehicle: it is forged, or the map lies beside the ground.
    Disagrees(u16),
    /// It is not any more.
    Agrees,
}

/// What came of the last frames.
#[derive(Debug)]
pub struct Watch {
    /// Seconds since the last accepted fixes, newest first.
    ages: [u8; TRUSTED],
    /// Seconds without a fix while armed.
    without: u16,
    refused: [u8; REFUSALS],
    is_told: bool,
    origin: Option<Geographic>,
    is_moved: bool,
    /// Metres by which satellite navigation disagrees, and whether that was told.
    disagreement_m: Option<u16>,
    has_disagreed: bool,
}

impl Default for Watch {
    fn default() -> Self {
        Watch {
            ages: [u8::MAX; TRUSTED],
            without: 0,
            refused: [0; REFUSALS],
            is_told: false,
            origin: None,
            is_moved: false,
            disagreement_m: None,
            has_disagreed: false,
        }
    }
}

impl Watch {
    /// What a frame came to: the code of a refusal, or 0 for an accepted fix.
    pub fn frame(&mut self, refusal: u8) {
        if refusal != 0 {
            if let Some(count) = self.refused.get_mut(usize::from(refusal)) {
                *count = count.saturating_add(1);
            }
            return;
        }
        self.ages.rotate_right(1);
        if let Some(newest) = self.ages.first_mut() {
            *newest = 0;
        }
        (self.without, self.refused) = (0, [0; REFUSALS]);
    }

    /// The autopilot's frame begins here; nothing is known of it after a reboot.
    pub fn origin(&mut self, origin: Option<Geographic>) {
        self.is_moved |= self.origin.zip(origin).is_some_and(|(before, now)| before != now);
        self.origin = origin;
    }

    /// By how many metres satellite navigation disagrees with the map, where it does.
    pub fn disagreement(&mut self, metres: Option<f32>) {
        self.disagreement_m = metres.map(|metres| metres as u16);
    }

    /// A disagreement that has begun or ended, armed or not: it is seen in the air alone.
    fn disagreed(&mut self) -> Option<News> {
        let disagrees = self.disagreement_m.is_some();
        if core::mem::replace(&mut self.has_disagreed, disagrees) == disagrees {
            return None;
        }
        Some(self.disagreement_m.map_or(News::Agrees, News::Disagrees))
    }

    /// To be called once a second: what is to be told. Lost fixes after ten seconds, and every ten from then.
    pub fn second(&mut self, is_armed: bool) -> Option<News> {
        self.ages.iter_mut().for_each(|age| *age = age.saturating_add(1));
        let moved = core::mem::take(&mut self.is_moved).then_some(News::Moved);
        if !is_armed {
            let Watch { ages, origin, disagreement_m, has_disagreed, .. } = *self;
            *self = Watch { ages, origin, disagreement_m, has_disagreed, ..Watch::default() };
            return moved.or_else(|| self.disagreed());
        }
        // What is not told in this second is told in the next.
        self.armed_second().or(moved).or_else(|| self.disagreed())
    }

    fn armed_second(&mut self) -> Option<News> {
        if self.without == 0 && core::mem::take(&mut self.is_told) {
            self.without = 1;
            return Some(News::Back);
        }
        self.without = self.without.saturating_add(1);
        // The first second is that of the fix itself.
        let seconds = self.without - 1;
        if seconds == 0 || !seconds.is_multiple_of(LOST_S) {
            return None;
        }
        self.is_told = true;
        Some(News::Lost(seconds, self.most_frequent()))
    }

    fn most_frequent(&self) -> Option<Refusal> {
        let counted = self.refused.iter().enumerate().filter(|(_, count)| **count > 0);
        let (code, _) = counted.max_by_key(|(_, count)| **count)?;
        Refusal::from_code(code as u8)
    }

    /// Whether fixes may be relied upon: several were accepted of late.
    pub fn is_trusted(&self) -> bool {
        self.ages.iter().all(|age| u16::from(*age) <= LOST_S)
    }

    /// Whether there was none for as long as the pilot is told.
    pub fn is_lost(&self) -> bool {
        self.ages.first().is_none_or(|age| u16::from(*age) > LOST_S)
    }
}

#[cfg(test)]
mod tests {
    use super::{News, REFUSALS, Watch};
    use plumbline_core::pipeline::Refusal;
    use plumbline_core::tile::Geographic;

    extern crate std;
    use std::vec::Vec;

    /// So many seconds of two frames each with these refusals; what is told, with the second.
    fn seconds(watch: &mut Watch, count: u32, refusals: [u8; 2], is_armed: bool) -> Vec<(u32, News)> {
        let mut told = Vec::new();
        for second in 0..count {
            refusals.into_iter().for_each(|refusal| watch.frame(refusal));
            told.extend(watch.second(is_armed).map(|news| (second, news)));
        }
        told
    }

    #[test]
    fn lost_fixes_are_told_with_their_reason_and_that_they_come_again() {
        let mut watch = Watch::default();
        assert_eq!(seconds(&mut watch, 30, [0, 0], true), []);
        watch.frame(Refusal::Ambiguous.code());
        let told = seconds(&mut watch, 25, [Refusal::LowScore.code(), Refusal::LowScore.code()], true);
        let lost = |seconds| News::Lost(seconds, Some(Refusal::LowScore));
        assert_eq!(told, [(9, lost(10)), (19, lost(20))]);
        assert!(watch.is_lost() && !watch.is_trusted());
        assert_eq!(seconds(&mut watch, 30, [0, 0], true), [(0, News::Back)]);
        assert!(!watch.is_lost() && watch.is_trusted());
    }

    #[test]
    fn on_the_ground_nothing_is_told() {
        let mut watch = Watch::default();
        let refused = [Refusal::NoRange.code(); 2];
        assert_eq!(seconds(&mut watch, 100, refused, false), []);
        // Ten seconds from arming on.
        assert_eq!(seconds(&mut watch, 11, refused, true), [(10, News::Lost(10, Some(Refusal::NoRange)))]);
    }

    #[test]
    fn several_fixes_are_trusted_and_one_is_not() {
        let mut watch = Watch::default();
        watch.frame(0);
        watch.frame(0);
        assert!(!watch.is_trusted() && !watch.is_lost());
        watch.frame(0);
        assert!(watch.is_trusted());
        (0..11).for_each(|_| {
            watch.second(false);
        });
        assert!(!watch.is_trusted() && watch.is_lost());
    }

    #[test]
    fn an_origin_that_moves_is_told_and_the_first_one_is_not() {
        let mut watch = Watch::default();
        let origin = |lat_e7| Some(Geographic { lat_e7, lon_e7: 1 });
        let mut told = |origin| {
            watch.origin(origin);
            watch.second(false)
        };
        assert_eq!(
            (told(origin(5)), told(origin(5)), told(origin(6)), told(origin(6))),
            (None, None, Some(News::Moved), None)
        );
        // After a reboot any other is the first.
        assert_eq!((told(None), told(origin(7))), (None, None));
    }

    #[test]
    fn a_disagreement_is_told_once_and_so_is_its_end() {
        let mut watch = Watch::default();
        let mut told = |metres: &[Option<f32>], is_armed| -> Vec<News> {
            let second = |metres: &Option<f32>| {
                watch.disagreement(*metres);
                watch.frame(0);
                watch.second(is_armed)
            };
            metres.iter().filter_map(second).collect()
        };
        assert_eq!(told(&[None, None, Some(13.7), Some(14.0), Some(200.0)], true), [News::Disagrees(13)]);
        assert_eq!(told(&[Some(9.0), Some(9.0)], false), []);
        assert_eq!(told(&[None, None, Some(f32::MAX)], true), [News::Agrees, News::Disagrees(u16::MAX)]);
    }

    #[test]
    fn a_disagreement_waits_for_what_else_is_told() {
        let mut watch = Watch::default();
        assert!((0..10).all(|_| watch.second(true).is_none()));
        watch.disagreement(Some(20.0));
        assert_eq!((watch.second(true), watch.second(true)), (Some(News::Lost(10, None)), Some(News::Disagrees(20))));
    }

    #[test]
    fn without_frames_there_is_no_reason_and_every_refusal_has_a_place() {
        let mut watch = Watch::default();
        let told: Vec<_> = (0..11).filter_map(|_| watch.second(true)).collect();
        assert_eq!(told, [News::Lost(10, None)]);
        assert!(plumbline_core::pipeline::Refusal::from_code(REFUSALS as u8).is_none());
    }
}
