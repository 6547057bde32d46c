//! What effects say of a scenario, as words of eight bytes: one layout in a worker, on the wire and
//! in the files.
//!
//! First two words a step, what it took and what it did; then the columns of all steps; then of
//! each of their tables the number of rows and the rows.

/// The word of a column that a scenario has no value for, whatever its kind.
pub const ABSENT: u64 = u64::MAX;

/// How a word is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// 0 or 1.
    Flag,
    /// A whole number below 2^32.
    Count,
    /// The bits of a finite f64.
    Number,
    /// One of these, by its position.
    Choice(&'static [&'static str]),
}

/// Its name ends with its unit, if it has one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Column {
    pub name: &'static str,
    pub kind: Kind,
}

impl Column {
    pub const fn flag(name: &'static str) -> Self {
        Self { name, kind: Kind::Flag }
    }

    pub const fn count(name: &'static str) -> Self {
        Self { name, kind: Kind::Count }
    }

    pub const fn number(name: &'static str) -> Self {
        Self { name, kind: Kind::Number }
    }

    pub const fn choice(name: &'static str, choices: &'static [&'static str]) -> Self {
        Self { name, kind: Kind::Choice(choices) }
    }

    /// Whether the word can be a value of it, or the absence of one.
    pub fn allows(&self, word: u64) -> bool {
        word == ABSENT
            || match self.kind {
                Kind::Flag => word <= 1,
                Kind::Count => word < 1 << 32,
                Kind::Number => f64::from_bits(word).is_finite(),
                Kind::Choice(choices) => (word as usize) < choices.len(),
            }
    }
}

/// Rows of which a scenario can have any number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Table {
    pub name: &'static str,
    /// No value is absent.
    pub columns: &'static [Column],
}

/// What one step says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StepLayout {
    pub name: &'static str,
    /// What its work is counted in.
    pub work_unit: &'static str,
    pub columns: &'static [Column],
    pub tables: &'static [Table],
}

/// What all steps of a plan say, in their order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Layout {
    pub steps: Vec<StepLayout>,
}

/// What one step took in one scenario.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StepCost {
    /// 0: the scenario did not need it.
    pub ns: u64,
    pub work: u64,
}

/// Why words are not what a layout says.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("what its effects say is not laid out as their plan has it")]
pub struct NotLaidOut;

impl Layout {
    pub fn columns(&self) -> impl Iterator<Item = &'static Column> {
        self.steps.iter().flat_map(|step| step.columns)
    }

    pub fn tables(&self) -> impl Iterator<Item = &'static Table> {
        self.steps.iter().flat_map(|step| step.tables)
    }

    /// Views words from another process.
    pub fn read<'a>(&'a self, words: &'a [u64]) -> Result<Sayings<'a>, NotLaidOut> {
        let split = |words: &'a [u64], at: usize| words.split_at_checked(at).ok_or(NotLaidOut);
        let (costs, rest) = split(words, 2 * self.steps.len())?;
        let (columns, tables) = split(rest, self.columns().count())?;
        if !self.columns().zip(columns).all(|(column, &word)| column.allows(word)) {
            return Err(NotLaidOut);
        }
        let mut rest = tables;
        for table in self.tables() {
            let (&rows, after) = rest.split_first().ok_or(NotLaidOut)?;
            let width = table.columns.len();
            let rows = usize::try_from(rows).ok().and_then(|rows| rows.checked_mul(width));
            let (rows, after) = split(after, rows.ok_or(NotLaidOut)?)?;
            let fits = |(at, &word): (usize, &u64)| {
                word != ABSENT && table.columns[at % width].allows(word)
            };
            if !rows.iter().enumerate().all(fits) {
                return Err(NotLaidOut);
            }
            rest = after;
        }
        if !rest.is_empty() {
            return Err(NotLaidOut);
        }
        Ok(Sayings { layout: self, costs, columns, tables })
    }
}

/// Words that are as their layout says.
#[derive(Clone, Copy, Debug)]
pub struct Sayings<'a> {
    layout: &'a Layout,
    costs: &'a [u64],
    columns: &'a [u64],
    tables: &'a [u64],
}

impl<'a> Sayings<'a> {
    pub fn costs(&self) -> impl Iterator<Item = StepCost> + 'a {
        self.costs.chunks_exact(2).map(|words| StepCost { ns: words[0], work: words[1] })
    }

    pub fn columns(&self) -> impl Iterator<Item = (&'static Column, u64)> + 'a {
        self.layout.columns().zip(self.columns.iter().copied())
    }

    /// Each table with its rows, one after the other.
    pub fn tables(&self) -> impl Iterator<Item = (&'static Table, &'a [u64])> + 'a {
        let mut rest = self.tables;
        self.layout.tables().map(move |table| {
            let (rows, after) = rest[1..].split_at(rest[0] as usize * table.columns.len());
            rest = after;
            (table, rows)
        })
    }
}

/// What is said of one scenario, while it is being said.
#[derive(Debug, Default)]
pub struct Notes {
    /// Costs and columns.
    head: Vec<u64>,
    tables: Vec<Vec<u64>>,
}

impl Notes {
    /// Nothing is said yet.
    pub fn clear(&mut self, layout: &Layout) {
        self.head.clear();
        self.head.resize(2 * layout.steps.len(), 0);
        self.head.resize(2 * layout.steps.len() + layout.columns().count(), ABSENT);
        self.tables.resize_with(layout.tables().count(), Vec::new);
        self.tables.iter_mut().for_each(Vec::clear);
    }

    /// The place for what step number `at` of `layout` says.
    pub fn of_step(&mut self, layout: &Layout, at: usize) -> Note<'_> {
        let (before, step) = (&layout.steps[..at], &layout.steps[at]);
        let first: usize = before.iter().map(|step| step.columns.len()).sum();
        let first = 2 * layout.steps.len() + first;
        let first_table: usize = before.iter().map(|step| step.tables.len()).sum();
        Note {
            columns: &mut self.head[first..][..step.columns.len()],
            tables: &mut self.tables[first_table..][..step.tables.len()],
            layout: *step,
        }
    }

    /// A step that was needed took no less than a nanosecond.
    pub fn set_cost(&mut self, at: usize, cost: StepCost) {
        self.head[2 * at..][..2].copy_from_slice(&[cost.ns.max(1), cost.work]);
    }

    /// Appends all of it.
    pub fn write(&self, layout: &Layout, words: &mut Vec<u64>) {
        words.extend_from_slice(&self.head);
        for (table, rows) in layout.tables().zip(&self.tables) {
            words.push((rows.len() / table.columns.len()) as u64);
            words.extend_from_slice(rows);
        }
    }
}

/// What one step says of one scenario. What it says nothing of stays absent.
pub struct Note<'a> {
    layout: StepLayout,
    columns: &'a mut [u64],
    tables: &'a mut [Vec<u64>],
}

impl Note<'_> {
    /// Of the column with that name. What is no finite number is not said.
    pub fn number(&mut self, name: &'static str, value: f64) {
        if value.is_finite() {
            self.set(name, Kind::Number, value.to_bits());
        }
    }

    /// Of three columns, whose names begin with this and end with their axes and the unit.
    pub fn numbers(&mut self, names: [&'static str; 3], values: [f64; 3]) {
        for (name, value) in names.into_iter().zip(values) {
            self.number(name, value);
        }
    }

    pub fn count(&mut self, name: &'static str, value: u32) {
        self.set(name, Kind::Count, value.into());
    }

    pub fn flag(&mut self, name: &'static str, value: bool) {
        self.set(name, Kind::Flag, value.into());
    }

    pub fn choice(&mut self, name: &'static str, value: &'static str) {
        let at = self.place(name);
        let Kind::Choice(choices) = self.layout.columns[at].kind else {
            panic!("{name} is no choice");
        };
        let chosen = choices.iter().position(|&choice| choice == value);
        self.columns[at] = chosen.expect("one of the choices") as u64;
    }

    /// A row of the table with that number, of as many words as it has columns.
    pub fn row(&mut self, table: usize, words: &[u64]) {
        assert_eq!(words.len(), self.layout.tables[table].columns.len());
        self.tables[table].extend_from_slice(words);
    }

    fn set(&mut self, name: &'static str, kind: Kind, word: u64) {
        let at = self.place(name);
        assert_eq!(self.layout.columns[at].kind, kind, "{name}");
        self.columns[at] = word;
    }

    fn place(&self, name: &'static str) -> usize {
        let found = self.layout.columns.iter().position(|column| column.name == name);
        found.unwrap_or_else(|| panic!("{name} is no column of {}", self.layout.name))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const FIRST: StepLayout = StepLayout {
        name: "first",
        work_unit: "steps",
        columns: &[Column::flag("is"), Column::number("long_m")],
        tables: &[Table { name: "rows", columns: &[Column::count("n"), Column::number("x_m")] }],
    };
    const SECOND: StepLayout = StepLayout {
        name: "second",
        work_unit: "steps",
        columns: &[Column::choice("which", &["a", "b"]), Column::count("many")],
        tables: &[],
    };

    fn layout() -> Layout {
        Layout { steps: vec![FIRST, SECOND] }
    }

    fn written() -> Vec<u64> {
        let (layout, mut notes, mut words) = (layout(), Notes::default(), Vec::new());
        notes.clear(&layout);
        let mut note = notes.of_step(&layout, 0);
        note.number("long_m", 2.5);
        note.row(0, &[3, 0.5_f64.to_bits()]);
        note.row(0, &[4, 1.5_f64.to_bits()]);
        let mut note = notes.of_step(&layout, 1);
        note.choice("which", "b");
        note.count("many", 7);
        notes.set_cost(1, StepCost { ns: 0, work: 9 });
        notes.write(&layout, &mut words);
        words
    }

    #[test]
    fn what_is_said_is_read() {
        let (layout, words) = (layout(), written());
        let said = layout.read(&words).unwrap();
        let costs: Vec<_> = said.costs().collect();
        assert_eq!(costs, [StepCost::default(), StepCost { ns: 1, work: 9 }]);
        let columns: Vec<_> = said.columns().map(|(column, word)| (column.name, word)).collect();
        let long = ("long_m", 2.5_f64.to_bits());
        assert_eq!(columns, [("is", ABSENT), long, ("which", 1), ("many", 7)]);
        let tables: Vec<_> = said.tables().map(|(table, rows)| (table.name, rows)).collect();
        assert_eq!(tables, [("rows", &[3, 0.5_f64.to_bits(), 4, 1.5_f64.to_bits()][..])]);
    }

    #[test]
    fn what_was_said_before_is_gone() {
        let (layout, mut notes, mut words) = (layout(), Notes::default(), Vec::new());
        notes.clear(&layout);
        notes.of_step(&layout, 0).row(0, &[3, 0]);
        notes.clear(&layout);
        notes.write(&layout, &mut words);
        assert_eq!(
            words,
            [[0; 4], [ABSENT; 4]].concat().into_iter().chain([0]).collect::<Vec<_>>()
        );
    }

    #[test]
    fn a_number_that_is_none_is_not_said() {
        let (layout, mut notes) = (layout(), Notes::default());
        notes.clear(&layout);
        notes.of_step(&layout, 0).number("long_m", f64::NAN);
        let mut words = Vec::new();
        notes.write(&layout, &mut words);
        assert_eq!(layout.read(&words).unwrap().columns().nth(1).unwrap().1, ABSENT);
    }

    #[test]
    fn words_of_another_layout_are_refused() {
        let (layout, words) = (layout(), written());
        let refused = |change: fn(&mut Vec<u64>)| {
            let mut words = words.clone();
            change(&mut words);
            layout.read(&words).unwrap_err()
        };
        refused(|words| words.push(0));
        refused(|words| words.truncate(words.len() - 1));
        refused(|words| words[4] = 2);
        refused(|words| words[5] = f64::INFINITY.to_bits());
        refused(|words| words[6] = 2);
        refused(|words| words[7] = 1 << 32);
        refused(|words| words[8] = 3);
        refused(|words| words[8] = u64::MAX);
        refused(|words| words[9] = ABSENT);
        refused(|words| words[10] = f64::NAN.to_bits());
    }

    proptest! {
        #[test]
        fn any_words_are_read_or_refused(words in prop::collection::vec(0_u64..4, 0..20)) {
            if let Ok(said) = layout().read(&words) {
                prop_assert_eq!(said.columns().count(), 4);
                prop_assert_eq!(said.tables().map(|(_, rows)| rows.len()).sum::<usize>(), words.len() - 9);
            }
        }
    }
}
