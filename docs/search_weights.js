// Order of the search results: guides before the reference, and both before design decisions and records; among
// guides first those whose name or title contains a word of the query. The longest prefix of a document's name counts.
const WEIGHTS = {
  "": 0,
  "tutorial": 14,
  "troubleshooting": 12,
  "coming-from": 12,
  "how-to/": 15,
  "how-to/own": 6,
  "model-file": 12,
  "import": 14,
  "cli": 12,
  "glossary": 10,
  "api/": 4,
  "accuracy": 4,
  "theory/": 2,
  "derivations/": 2,
  "decisions/": -25,
  "equations": -15,
  "errata": -10,
};

const WORDS = (new URLSearchParams(location.search).get("q") || "").toLowerCase().match(/\w{3,}/g) || [];

const bonus = (document, title) => {
  const name = document.split("/").pop();
  const own = title.split(" > ")[0].toLowerCase();
  if (WORDS.some((word) => name.startsWith(word.slice(0, 6)))) return 20;
  return WORDS.some((word) => own.includes(word)) ? 12 : 0;
};

var Scorer = {
  score: ([document, title, anchor, description, score]) => {
    const prefix = Object.keys(WEIGHTS)
      .filter((name) => document.startsWith(name))
      .reduce((longest, name) => (name.length > longest.length ? name : longest));
    return score + WEIGHTS[prefix] + (WEIGHTS[prefix] < 10 ? 0 : bonus(document, title));
  },
  objNameMatch: 11,
  objPartialMatch: 6,
  objPrio: { 0: 15, 1: 5, 2: -5 },
  objPrioDefault: 0,
  title: 15,
  partialTitle: 7,
  term: 5,
  partialTerm: 2,
};
