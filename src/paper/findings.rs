//! What the evidence says of every claim: under our reading of the paper, and under each choice that the paper leaves open.

use super::Paper;
use super::evidence::Evidence;
use super::manifest::{Choice, Claim};
use super::test::{Data, Ruling, Verdict};
use crate::analysis::holm;
use crate::comparison::ALPHA;
use crate::experiment::{in_order, threads_available};

/// A claim with all that was found on it.
#[derive(Clone, Debug)]
pub struct Finding<'a> {
    /// The claim, or question.
    pub claim: &'a Claim,
    /// The verdict on the tables as they are.
    pub verdict: Verdict,
    /// The p-value of the verdict, corrected for the number of the paper's claims; questions are not corrected.
    pub p_holm: Option<f64>,
    /// The ruling under each choice that changes the tables of the claim.
    pub under: Vec<(&'a Choice, Ruling)>,
}

/// What was found on every claim and question of a paper.
#[derive(Clone, Debug)]
pub struct Findings<'a> {
    /// The claims of the paper, one family of tests.
    pub claims: Vec<Finding<'a>>,
    /// The questions of ours.
    pub questions: Vec<Finding<'a>>,
}

impl Finding<'_> {
    /// The ruling over all choices: *depends* where one of them turns a claim that holds into one that does not, or the other way
    /// round. A choice under which the data do not decide turns nothing.
    pub fn ruling(&self) -> Ruling {
        let found =
            |wanted: Ruling| self.verdict.ruling == wanted || self.under.iter().any(|(_, ruling)| *ruling == wanted);
        if found(Ruling::Holds) && found(Ruling::Fails) { Ruling::Depends } else { self.verdict.ruling }
    }

    /// The choices that decide otherwise than the tables as they are.
    pub fn turned_by(&self) -> impl Iterator<Item = &(&Choice, Ruling)> {
        self.under.iter().filter(|(_, ruling)| ruling.is_decided() && *ruling != self.verdict.ruling)
    }

    /// The ruling in words, with the choices on which it depends.
    pub fn words(&self) -> String {
        match self.ruling() {
            Ruling::Depends => {
                let choices: Vec<&str> = self.turned_by().map(|(choice, _)| choice.id.as_str()).collect();
                format!("depends on {}", choices.join(", "))
            }
            ruling => ruling.words().to_owned(),
        }
    }
}

impl<'a> Findings<'a> {
    /// Judges every claim and question of a paper, under every choice that was run.
    pub fn new(paper: &'a Paper, evidence: &Evidence) -> Self {
        let manifest = &paper.manifest;
        let statements: Vec<&Claim> = manifest.statements().collect();
        let judge = |index: usize, choice: Option<&Choice>| {
            let choice = choice.map(|choice| choice.id.as_str());
            statements[index].test.kind().judge(&Data {
                evidence,
                published: &paper.published,
                tables: &manifest.tables,
                choice,
            })
        };
        let threads = threads_available();
        let mut ours: Vec<Verdict> = in_order(statements.len(), threads, |index| judge(index, None));
        let count = manifest.claims.len();
        let was_run = |choice: &&Choice| evidence.under.keys().any(|(id, _)| id == choice.id.as_str());
        let under: Vec<(&'a Choice, Vec<Verdict>)> = manifest
            .ablate
            .iter()
            .filter(was_run)
            .map(|choice| {
                // The claims that a choice does not touch are as they were: every choice has a whole family.
                let mut verdicts = in_order(statements.len(), threads, |index| {
                    if concerns(choice, statements[index]) { judge(index, Some(choice)) } else { ours[index].clone() }
                });
                correct(&mut verdicts[..count]);
                (choice, verdicts)
            })
            .collect();
        let p_holm = correct(&mut ours[..count]);
        let findings = statements.iter().zip(ours).enumerate().map(|(index, (claim, verdict))| Finding {
            claim,
            verdict,
            p_holm: p_holm.get(index).copied().flatten(),
            under: under
                .iter()
                .filter(|(choice, _)| concerns(choice, claim))
                .map(|(choice, verdicts)| (*choice, verdicts[index].ruling))
                .collect(),
        });
        let mut claims: Vec<Finding<'a>> = findings.collect();
        let questions = claims.split_off(count);
        Self { claims, questions }
    }
}

/// Whether a choice changes what a claim looks at: every table of it, for a table as it is against one that is changed compares two
/// choices and not what the claim is about.
fn concerns(choice: &Choice, claim: &Claim) -> bool {
    let uses = claim.test.kind().uses();
    !uses.is_empty() && uses.iter().all(|used| choice.tables.iter().any(|table| table == used.table))
}

/// Corrects the verdicts of one family by Holm's procedure: a ruling whose corrected p-value is above 5 % is undecided. Returns the
/// corrected p-values.
fn correct(family: &mut [Verdict]) -> Vec<Option<f64>> {
    let tested: Vec<usize> = (0..family.len()).filter(|&index| family[index].p.is_some()).collect();
    let p: Vec<f64> = tested.iter().filter_map(|&index| family[index].p).collect();
    let mut corrected = vec![None; family.len()];
    for (&index, p_holm) in tested.iter().zip(holm(&p)) {
        corrected[index] = Some(p_holm);
        let verdict = &mut family[index];
        if verdict.ruling.is_decided() && p_holm > ALPHA {
            let ruling = verdict.ruling.words();
            verdict.why += &format!("; alone it {ruling}, corrected for {} claims p = {p_holm:.3}", tested.len());
            verdict.ruling = Ruling::Undecided;
        }
    }
    corrected
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::comparison::{Section, StackRows};
    use crate::episode::Outcome;
    use crate::metrics::Metrics;
    use crate::paper::evidence::TableEvidence;
    use crate::results::Row;
    use crate::scenario::read_document;

    /// One table of two stacks: in world k the first is `sign` · k cm longer than the second, which drives 10 m.
    fn section(worlds: u32, sign: f64) -> Section {
        let stack = |name: &str, longer_m: f64| {
            let row = |k: u32| {
                let metrics = Metrics { length_m: Some(10.0 + longer_m * f64::from(k)), ..Metrics::default() };
                let row = Row {
                    stack: name.to_owned(),
                    episode: u64::from(k),
                    outcome: Outcome::Success,
                    metrics,
                    ..Row::blank()
                };
                ((1, u64::from(k)), row)
            };
            StackRows { name: name.to_owned(), values: Vec::new(), rows: (1..=worlds).map(row).collect() }
        };
        Section {
            title: "t".to_owned(),
            scenario: "t".to_owned(),
            point: 0,
            swept: Vec::new(),
            stacks: vec![stack("a", 0.01 * sign), stack("b", 0.0)],
        }
    }

    fn paper(claims: usize) -> Paper {
        let claim = |index: usize| {
            format!(
                "- {{id: c{index}, says: shorter, test: {{compare: {{metric: length_m, of: {{table: t, stack: a}}, is: less, than: {{table: t, stack: b}}}}}}}}\n"
            )
        };
        let text = format!(
            "title: t\ncitation: c\nabout: a\nmethod: m\npublished: p\ntables:\n- {{id: t, title: t, scenario: s}}\n\
             ablate:\n- {{id: turned, says: s, of: world, set: [a=1], tables: [t], kindest: true}}\n\
             - {{id: same, says: s, of: planner, set: [a=2], tables: [t]}}\n\
             claims:\n{}questions:\n{}",
            (0..claims).map(claim).collect::<String>(),
            claim(claims)
        );
        let manifest = read_document(&text).unwrap_or_else(|error| panic!("{text}{error}"));
        Paper { name: "p".to_owned(), manifest, published: Vec::new(), folder: std::path::PathBuf::new() }
    }

    fn evidence(worlds: u32) -> Evidence {
        let table = TableEvidence {
            sections: vec![section(worlds, -1.0)],
            bounds: Default::default(),
            failures: Default::default(),
        };
        let mut found = Evidence { tables: [("t".to_owned(), table)].into(), ..Evidence::default() };
        for (id, sign) in [("turned", 1.0), ("same", -2.0)] {
            found.under.insert((id.to_owned(), "t".to_owned()), vec![section(worlds, sign)]);
        }
        found
    }

    #[test]
    fn claims_are_one_family_and_questions_are_not() {
        // Eight worlds of one sign: p = 2/2⁸ = 0.0078. Six such claims are decided (0.047), seven are not (0.055).
        for (claims, ruling) in [(6, Ruling::Depends), (7, Ruling::Undecided)] {
            let (paper, evidence) = (paper(claims), evidence(8));
            let found = Findings::new(&paper, &evidence);
            assert!(found.claims.iter().all(|finding| finding.ruling() == ruling), "{claims}: {found:?}");
            assert_eq!(found.claims[0].p_holm, Some(claims as f64 / 128.0));
            let question = &found.questions[0];
            assert_eq!((question.verdict.ruling, question.p_holm), (Ruling::Holds, None));
        }
    }

    #[test]
    fn a_choice_that_turns_a_claim_is_named() {
        let (paper, evidence) = (paper(1), evidence(8));
        let found = Findings::new(&paper, &evidence);
        let claim = &found.claims[0];
        assert_eq!((claim.verdict.ruling, claim.ruling()), (Ruling::Holds, Ruling::Depends));
        assert_eq!(claim.words(), "depends on turned");
        let under: Vec<(&str, Ruling)> =
            claim.under.iter().map(|(choice, ruling)| (choice.id.as_str(), *ruling)).collect();
        assert_eq!(under, [("turned", Ruling::Fails), ("same", Ruling::Holds)]);
        // Without runs under choices there is nothing to depend on.
        let alone = Evidence { under: Default::default(), ..evidence };
        assert_eq!(Findings::new(&paper, &alone).claims[0].ruling(), Ruling::Holds);
    }
}
