//! Pictures and pages that show a person what was made: contact sheets, montages, labels.
