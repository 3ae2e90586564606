//! What each of several results is called beside the others.

use super::{ResultFile, shorten_for_picture};

/// The name of each result: that of its file; of files with the same name, the title as well, and a number where that
/// is the same too.
pub fn distinct_names(results: &[ResultFile]) -> Vec<String> {
    let named = |result: &ResultFile| (shorten_for_picture(&result.name), result.title.clone());
    distinct(&results.iter().map(named).collect::<Vec<_>>())
}

/// The same of names and titles.
fn distinct(results: &[(String, String)]) -> Vec<String> {
    let count = |is_counted: &dyn Fn(&(String, String)) -> bool| {
        results.iter().filter(|other| is_counted(other)).count()
    };
    let name = |(place, one): (usize, &(String, String))| {
        let (name, title) = one;
        if count(&|(other, _)| other == name) == 1 {
            return name.clone();
        }
        match count(&|other| other == one) {
            1 => format!("{title} ({name})"),
            _ => {
                let before = results[..place].iter().filter(|other| *other == one).count();
                format!("{title} ({name}, number {})", before + 1)
            }
        }
    };
    results.iter().enumerate().map(name).collect()
}

#[cfg(test)]
mod tests {
    use super::distinct;

    #[test]
    fn files_with_the_same_name_are_told_apart() {
        let results = [("a", "first"), ("b", "first"), ("a", "second"), ("a", "second")]
            .map(|(name, title)| (name.to_owned(), title.to_owned()));
        let names = distinct(&results);
        assert_eq!(names, ["first (a)", "b", "second (a, number 1)", "second (a, number 2)"]);
    }
}
