//! What a finished run said of its scenarios, to hold against what is shown.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::super::scenarios_csv::Row;
use crate::scheduler::client_manager::ScenarioResult;

/// The rows of a `scenarios.csv`, by scenario.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct EarlierRun(BTreeMap<u32, Row>);

#[derive(Debug, thiserror::Error)]
pub enum EarlierError {
    #[error("{path}: cannot read it: {source}", path = path.display())]
    Read { path: PathBuf, source: std::io::Error },
    #[error("{path}: line {line}: {reason}", path = path.display())]
    Row { path: PathBuf, line: usize, reason: &'static str },
}

/// That a scenario is not answered as it was.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "scenario {scenario}: the run found {found}, and now there are {now}: a mesh, the poses or bumper \
     has changed since; run it again"
)]
pub struct Differs {
    scenario: u32,
    found: String,
    now: String,
}

impl EarlierRun {
    pub fn read(path: &Path) -> Result<Self, EarlierError> {
        let unreadable = |source| EarlierError::Read { path: path.to_owned(), source };
        let text = std::fs::read_to_string(path).map_err(unreadable)?;
        Self::parse(&text).map_err(|(line, reason)| EarlierError::Row {
            path: path.to_owned(),
            line,
            reason,
        })
    }

    /// Where something is wrong: the line, and what.
    fn parse(text: &str) -> Result<Self, (usize, &'static str)> {
        let mut lines = text.lines().zip(1..);
        let header = lines.next().map_or("", |(header, _)| header);
        let names: Vec<&str> = header.split(',').collect();
        if !names.starts_with(&["scenario", "colliding"]) {
            return Err((1, "this is not the header of scenarios.csv"));
        }
        let overlap_only = !names[2..].starts_with(&["pairs", "pairs_fnv1a64"]);
        let mut rows = BTreeMap::new();
        for (line, number) in lines {
            let row = Row::parse(line, names.len(), overlap_only)
                .ok_or((number, "this is not a row of scenarios.csv"))?;
            if rows.insert(row.scenario, row).is_some() {
                return Err((number, "this scenario is there twice"));
            }
        }
        Ok(Self(rows))
    }

    /// One more than the last scenario that has a row.
    pub fn end(&self) -> u32 {
        self.0.last_key_value().map_or(0, |(last, _)| last.saturating_add(1))
    }

    /// A scenario that the run has no answer for differs from none.
    pub fn check(&self, result: &ScenarioResult<'_>) -> Result<(), Differs> {
        let Some(row) = self.0.get(&result.scenario) else { return Ok(()) };
        let words = |row: &Row| match (row.pairs, row.colliding) {
            (Some((pairs, hash)), _) => format!("{pairs} pairs ({hash:016x})"),
            (None, true) => "an overlap".to_owned(),
            (None, false) => "no overlap".to_owned(),
        };
        let now = Row {
            scenario: result.scenario,
            colliding: result.pair_count > 0,
            pairs: row.pairs.map(|_| (result.pair_count, result.pairs_fnv1a64)),
        };
        if now == *row {
            return Ok(());
        }
        Err(Differs { scenario: result.scenario, found: words(row), now: words(&now) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::layout::Layout;

    const RUN: &str = "scenario,colliding,pairs,pairs_fnv1a64,clearance_m\n\
                       0,1,2,00000000000000ff,\n3,0,0,cbf29ce484222325,0.5\n";

    fn check(run: &str, scenario: u32, pair_count: u32, pairs_fnv1a64: u64) -> Result<(), String> {
        let nothing = Layout::default();
        let (pairs, effects) = (&[], nothing.read(&[]).unwrap());
        let (compute_ns, cost, worker) = (0, None, 0);
        let result = ScenarioResult {
            scenario,
            pair_count,
            pairs_fnv1a64,
            compute_ns,
            cost,
            worker,
            pairs,
            effects,
        };
        EarlierRun::parse(run).unwrap().check(&result).map_err(|differs| differs.to_string())
    }

    #[test]
    fn a_scenario_is_held_against_its_row() {
        assert_eq!(check(RUN, 0, 2, 0xff), Ok(()));
        assert_eq!(check(RUN, 1, 9, 9), Ok(()), "the run has no answer");
        let differs = check(RUN, 0, 3, 0xff).unwrap_err();
        assert!(
            differs.contains("scenario 0: the run found 2 pairs (00000000000000ff)"),
            "{differs}"
        );
        assert!(check(RUN, 3, 0, 7).is_err());
        let overlap = "scenario,colliding\n0,1\n1,0\n";
        assert_eq!(check(overlap, 0, 5, 5), Ok(()));
        assert!(check(overlap, 1, 5, 5).is_err() && check(overlap, 0, 0, 5).is_err());
    }

    #[test]
    fn what_is_no_run_is_refused_with_the_line() {
        let refused = |text: &str| EarlierRun::parse(text).unwrap_err().0;
        assert_eq!(refused(""), 1);
        assert_eq!(refused("a,b\n"), 1);
        for row in ["0,1,2", "x,1,2,00,", "0,2,2,00,", "0,1,-2,00,", "0,1,2,zz,", "0,1,2,00,,"] {
            let header = RUN.lines().next().unwrap();
            assert_eq!(refused(&format!("{header}\n1,0,0,00,\n{row}\n")), 3, "{row}");
        }
        assert_eq!(refused(&format!("{RUN}0,1,2,00000000000000ff,\n")), 4);
        assert_eq!(EarlierRun::parse(RUN).unwrap().end(), 4);
    }
}
