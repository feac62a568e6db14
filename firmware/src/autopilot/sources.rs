//! Which set of its sources the autopilot's estimator uses: satellite navigation (1) or fixes (2).
//!
//! The autopilot does not say which it uses, and its pilot may choose too: what was chosen here is what is taken back, and
//! nothing else.

use crate::wire::command::{
    ACCEPTED, Acknowledgement, DENIED, FAILED, IN_PROGRESS, SET_EKF_SOURCE_SET, TEMPORARILY_REJECTED,
};

/// Who chooses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Switching {
    /// The pilot, without us.
    Never,
    /// We: fixes where satellite navigation is lost.
    OnGnssLoss,
    /// The ground station, by a command to us.
    Told,
}

/// Beats of ten a second without a position of satellite navigation after which it counts as lost: ten of its messages.
const LOST_BEATS: u16 = 20;
/// Beats of good ones after which it is relied upon again: the ten seconds that ArduPilot's own filter wants of it before it
/// uses it (NavEKF3_core::calcGpsGoodToAlign).
const BACK_BEATS: u16 = 100;
/// Beats behind a change of it, or of the set, for which the autopilot's estimator swings. Measured over flights that were kept by their fixes: six
/// seconds behind a loss attitudes are 1.8 times as far off as ever, and after twelve 1.4 times, which is what a drift's sigma bears.
const CHANGE_BEATS: u16 = 120;
/// Beats without its message after which nothing is known of it: as long as a loss.
const SILENT_BEATS: u16 = LOST_BEATS;
/// From one command to its repetition, beats, and how often it is sent.
const ANSWER_BEATS: u8 = 10;
const TRIES: u8 = 5;
/// Beats after which what failed is tried again, half a minute.
const AGAIN_BEATS: u16 = 300;

/// Satellite navigation's set, and that of fixes.
const GNSS_SET: u8 = 1;
const FIX_SET: u8 = 2;

/// What the pilot is to be told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum News {
    /// The autopilot has taken this set.
    Taken(u8),
    /// It does not take it.
    Denied(u8),
    /// It does not answer.
    Unanswered(u8),
}

/// A result for who gave the command.
fn answered(result: u8, target: (u8, u8)) -> Acknowledgement {
    Acknowledgement { command: SET_EKF_SOURCE_SET, result, target }
}

/// A set that the autopilot is told to take.
#[derive(Clone, Copy, Debug)]
struct Command {
    set: u8,
    /// How often it was sent, and beats since.
    tries: u8,
    beats: u8,
    /// Who told us.
    by: Option<(u8, u8)>,
}

/// Satellite navigation as the autopilot reports it.
#[derive(Clone, Copy, Debug, Default)]
struct Gnss {
    /// Whether it has a position, once it was reported.
    is_good: Option<bool>,
    /// Beats since that changed, and since it was reported.
    steady: u16,
    silent: u16,
}

impl Gnss {
    fn is_good(&self) -> bool {
        self.is_good == Some(true)
    }
}

/// State of the choice.
#[derive(Debug)]
pub struct Sources {
    switching: Switching,
    gnss: Gnss,
    command: Option<Command>,
    /// Whether we had the autopilot take fixes.
    is_switched: bool,
    /// Beats for which nothing is tried, and since satellite navigation or the set has changed.
    rest: u16,
    unchanged: u16,
    news: Option<News>,
    answer: Option<Acknowledgement>,
}

impl Sources {
    /// Nothing chosen yet.
    pub fn new(switching: Switching) -> Self {
        let gnss = Gnss::default();
        Sources {
            switching,
            gnss,
            command: None,
            is_switched: false,
            rest: 0,
            unchanged: u16::MAX,
            news: None,
            answer: None,
        }
    }

    /// After a reboot the autopilot is back at its first set.
    pub fn forget(&mut self) {
        *self = Sources::new(self.switching);
    }

    /// Whether satellite navigation has a position.
    pub fn gnss(&mut self, is_good: bool) {
        let gnss = &mut self.gnss;
        gnss.silent = 0;
        if gnss.is_good != Some(is_good) {
            // The first that is heard of it is no change.
            if gnss.is_good.is_some() {
                self.unchanged = 0;
            }
            if is_good || gnss.is_good.is_some() {
                gnss.steady = 0;
            }
            gnss.is_good = Some(is_good);
        }
    }

    /// Whether it was lost or found again, or the autopilot took another set, so short a time ago that its estimator has not settled.
    pub fn is_changing(&self) -> bool {
        self.unchanged < CHANGE_BEATS
    }

    /// Whether satellite navigation has a position now.
    pub fn has_gnss(&self) -> bool {
        self.gnss.is_good() && self.gnss.silent < SILENT_BEATS
    }

    /// A ground station orders a set; what is to be answered comes by [`Sources::answer`].
    pub fn ordered(&mut self, set: Option<u8>, by: (u8, u8)) {
        let Some(set) = set.filter(|_| self.switching == Switching::Told) else {
            self.answer = Some(answered(DENIED, by));
            return;
        };
        // The same order again, since its answer is late.
        if self.command.is_none_or(|command| (command.set, command.by) != (set, Some(by))) {
            self.command = Some(Command { set, tries: 0, beats: 0, by: Some(by) });
        }
    }

    /// The autopilot's word on a set of sources.
    pub fn acknowledged(&mut self, result: u8) {
        let Some(command) = self.command.filter(|command| command.tries > 0) else { return };
        match result {
            IN_PROGRESS | TEMPORARILY_REJECTED => {}
            ACCEPTED => {
                self.unchanged = 0;
                self.is_switched = command.set == FIX_SET && command.by.is_none();
                self.end(command, result, News::Taken(command.set));
            }
            _ => self.end(command, result, News::Denied(command.set)),
        }
    }

    fn end(&mut self, command: Command, result: u8, news: News) {
        self.command = None;
        self.rest = if result == ACCEPTED { 0 } else { AGAIN_BEATS };
        self.news = Some(news);
        self.answer = command.by.map(|by| answered(result, by)).or(self.answer);
    }

    /// To be called on each beat while the autopilot is there: the set that it is to be told to take. `are_trusted` and
    /// `are_lost` are the fixes.
    pub fn next(&mut self, are_trusted: bool, are_lost: bool) -> Option<u8> {
        let gnss = &mut self.gnss;
        (gnss.steady, gnss.silent) = (gnss.steady.saturating_add(1), gnss.silent.saturating_add(1));
        self.unchanged = self.unchanged.saturating_add(1);
        if gnss.is_good() && gnss.silent >= SILENT_BEATS {
            (gnss.is_good, gnss.steady, self.unchanged) = (Some(false), gnss.silent, gnss.silent);
        }
        self.rest = self.rest.saturating_sub(1);
        if self.switching == Switching::OnGnssLoss && self.command.is_none() && self.rest == 0 {
            let set = self.wanted(are_trusted, are_lost);
            self.command = set.map(|set| Command { set, tries: 0, beats: 0, by: None });
        }
        let mut command = self.command?;
        command.beats = command.beats.saturating_add(1);
        let is_due = command.tries == 0 || command.beats >= ANSWER_BEATS;
        if is_due && command.tries == TRIES {
            self.end(command, FAILED, News::Unanswered(command.set));
            return None;
        }
        if is_due {
            (command.tries, command.beats) = (command.tries + 1, 0);
        }
        self.command = Some(command);
        is_due.then_some(command.set)
    }

    /// The set that should be taken instead of the one that is.
    fn wanted(&self, are_trusted: bool, are_lost: bool) -> Option<u8> {
        let (is_good, steady) = (self.gnss.is_good(), self.gnss.steady);
        if !self.is_switched {
            return (!is_good && steady >= LOST_BEATS && are_trusted).then_some(FIX_SET);
        }
        // Where there are no fixes a position that is not relied upon yet is better than none.
        let long_enough = if are_lost { LOST_BEATS } else { BACK_BEATS };
        (is_good && steady >= long_enough).then_some(GNSS_SET)
    }

    /// What the pilot is to be told, once.
    pub fn news(&mut self) -> Option<News> {
        self.news.take()
    }

    /// What a ground station is to be answered, once.
    pub fn answer(&mut self) -> Option<Acknowledgement> {
        self.answer.take()
    }
}

#[cfg(test)]
mod tests {
    use super::{FIX_SET, GNSS_SET, News, Sources, Switching, TRIES};
    use crate::wire::command::{ACCEPTED, Acknowledgement, DENIED, FAILED, SET_EKF_SOURCE_SET, TEMPORARILY_REJECTED};

    extern crate std;
    use std::vec::Vec;

    /// So many beats with satellite navigation in this state, an autopilot that answers with `result`, and fixes that are
    /// trusted; each set that is sent, with the beat.
    fn beats(
        sources: &mut Sources,
        count: u32,
        gnss: Option<bool>,
        are_trusted: bool,
        result: Option<u8>,
    ) -> Vec<(u32, u8)> {
        let mut sent = Vec::new();
        for beat in 0..count {
            gnss.into_iter().for_each(|is_good| sources.gnss(is_good));
            if let Some(set) = sources.next(are_trusted, !are_trusted) {
                sent.push((beat, set));
                result.into_iter().for_each(|result| sources.acknowledged(result));
            }
        }
        sent
    }

    #[test]
    fn fixes_are_taken_while_satellite_navigation_is_lost() {
        let mut sources = Sources::new(Switching::OnGnssLoss);
        assert_eq!(beats(&mut sources, 200, Some(true), true, Some(ACCEPTED)), []);
        // Two seconds, whether it says so or says nothing.
        assert_eq!(beats(&mut sources, 100, Some(false), true, Some(ACCEPTED)), [(19, FIX_SET)]);
        assert_eq!(sources.news(), Some(News::Taken(FIX_SET)));
        // Back after ten seconds, not before.
        assert_eq!(beats(&mut sources, 90, Some(true), true, Some(ACCEPTED)), []);
        assert_eq!(beats(&mut sources, 5, Some(false), true, Some(ACCEPTED)), []);
        assert_eq!(beats(&mut sources, 200, Some(true), true, Some(ACCEPTED)), [(99, GNSS_SET)]);
        assert_eq!(sources.news(), Some(News::Taken(GNSS_SET)));
        // The last message came a beat before the first of these.
        assert_eq!(beats(&mut sources, 100, None, true, Some(ACCEPTED)), [(18, FIX_SET)]);
    }

    #[test]
    fn fixes_that_are_not_trusted_are_not_taken_and_lost_ones_left_sooner() {
        let mut sources = Sources::new(Switching::OnGnssLoss);
        assert_eq!(beats(&mut sources, 300, Some(false), false, Some(ACCEPTED)), []);
        assert_eq!(beats(&mut sources, 10, Some(false), true, Some(ACCEPTED)), [(0, FIX_SET)]);
        // Neither the one nor the other: it stays.
        assert_eq!(beats(&mut sources, 100, Some(false), false, Some(ACCEPTED)), []);
        assert_eq!(beats(&mut sources, 100, Some(true), false, Some(ACCEPTED)), [(19, GNSS_SET)]);
    }

    #[test]
    fn the_autopilot_settles_behind_a_change() {
        let mut sources = Sources::new(Switching::Never);
        let changing = |sources: &mut Sources, count: u32, gnss: Option<bool>| {
            let beat = |_| {
                beats(sources, 1, gnss, true, None);
                sources.is_changing()
            };
            (0..count).map(beat).filter(|is_changing| *is_changing).count()
        };
        // The first that is heard of it is no change.
        assert_eq!(changing(&mut sources, 300, Some(true)), 0);
        assert_eq!(changing(&mut sources, 300, Some(false)), 119);
        assert_eq!(changing(&mut sources, 300, Some(true)), 119);
        // Silent, it is lost two seconds ago.
        assert_eq!(changing(&mut sources, 300, None), 100);
        // A set that is taken is a change of its own: ten seconds behind a return.
        let mut sources = Sources::new(Switching::OnGnssLoss);
        let lost =
            |sources: &mut Sources, count, is_good| beats(sources, count, Some(is_good), true, Some(ACCEPTED)).len();
        assert_eq!((lost(&mut sources, 300, true), lost(&mut sources, 300, false)), (0, 1));
        assert_eq!((lost(&mut sources, 150, true), sources.is_changing()), (1, true));
        assert_eq!((lost(&mut sources, 80, true), sources.is_changing()), (0, false));
    }

    #[test]
    fn a_flicker_changes_nothing() {
        let mut sources = Sources::new(Switching::OnGnssLoss);
        for _ in 0..50 {
            assert_eq!(beats(&mut sources, 10, Some(true), true, Some(ACCEPTED)), []);
            assert_eq!(beats(&mut sources, 10, Some(false), true, Some(ACCEPTED)), []);
        }
    }

    #[test]
    fn a_command_is_repeated_until_it_is_acknowledged_and_no_more_than_five_times() {
        let mut sources = Sources::new(Switching::OnGnssLoss);
        let sent = beats(&mut sources, 100, Some(false), true, None);
        assert_eq!(sent, [(19, FIX_SET), (29, FIX_SET), (39, FIX_SET), (49, FIX_SET), (59, FIX_SET)]);
        assert_eq!((sources.news(), sent.len()), (Some(News::Unanswered(FIX_SET)), usize::from(TRIES)));
        // What is denied is not sent again at once.
        let sent = beats(&mut sources, 400, Some(false), true, Some(DENIED));
        assert_eq!((sent.len(), sources.news()), (1, Some(News::Denied(FIX_SET))), "{sent:?}");
        let sent = beats(&mut sources, 250, Some(false), true, Some(TEMPORARILY_REJECTED));
        assert!(sent.len() > 1, "{sent:?}");
    }

    #[test]
    fn a_ground_station_is_obeyed_and_answered_only_where_it_is_set() {
        let by = (255, 190);
        for switching in [Switching::Never, Switching::OnGnssLoss] {
            let mut sources = Sources::new(switching);
            sources.ordered(Some(2), by);
            assert_eq!(
                sources.answer(),
                Some(Acknowledgement { command: SET_EKF_SOURCE_SET, result: DENIED, target: by })
            );
            assert_eq!(beats(&mut sources, 10, Some(true), true, Some(ACCEPTED)), []);
        }
        let mut sources = Sources::new(Switching::Told);
        assert_eq!(beats(&mut sources, 100, Some(false), true, Some(ACCEPTED)), []);
        sources.ordered(Some(3), by);
        assert_eq!((beats(&mut sources, 5, None, false, None), sources.answer()), ([(0, 3)].to_vec(), None));
        // Repeated by the station: no second command.
        sources.ordered(Some(3), by);
        assert_eq!(beats(&mut sources, 3, None, false, None), []);
        sources.acknowledged(ACCEPTED);
        assert_eq!(
            sources.answer(),
            Some(Acknowledgement { command: SET_EKF_SOURCE_SET, result: ACCEPTED, target: by })
        );
        assert_eq!(sources.news(), Some(News::Taken(3)));
        sources.ordered(None, by);
        assert_eq!(sources.answer(), Some(Acknowledgement { command: SET_EKF_SOURCE_SET, result: DENIED, target: by }));
        sources.ordered(Some(1), by);
        beats(&mut sources, 100, None, false, None);
        assert_eq!(sources.answer(), Some(Acknowledgement { command: SET_EKF_SOURCE_SET, result: FAILED, target: by }));
        // An acknowledgement of nothing.
        sources.acknowledged(ACCEPTED);
        assert_eq!((sources.answer(), sources.news()), (None, Some(News::Unanswered(1))));
    }
}
