"use strict";
// The changed study as text: numbers replaced in the study's own text where its tables stand under headers of their own.
const Toml = (() => {
  const bare = name => /^[A-Za-z0-9_-]+$/.test(name) ? name : JSON.stringify(name);
  const header = path => `[${path.map(bare).join(".")}]`;
  const literal = text => text.replace(/[.*+?^${}()|[\]\\]/g, "\\$&");
  // A name may stand bare or in either kind of quotes.
  const headerLine = path => {
    const part = name => `(?:${literal(name)}|"${literal(name)}"|'${literal(name)}')`;
    return new RegExp(`^\\s*\\[\\s*${path.map(part).join("\\s*\\.\\s*")}\\s*\\]\\s*(?:#.*)?$`);
  };

  // A criterion of a case may stand in the case in several forms, or in the study for all cases: told in a comment.
  const ofCase = ({ inCase, name, values }) => [
    `# under [[cases]] with name = ${JSON.stringify(inCase)}, in its criteria.${bare(name)} (a criterion that the study has for all`,
    "# cases is copied there as a whole):",
    ...Object.entries(values).map(([key, value]) => `#   ${bare(key)} = ${value}`),
  ];
  /** The changes alone: a list of { path, values }, or of { inCase, name, values } for a criterion of one case. */
  const snippet = changes => changes.map(change => {
    const lines = Object.entries(change.values).map(([key, value]) => `${bare(key)} = ${value}`);
    return (change.inCase ? ofCase(change) : [header(change.path), ...lines]).join("\n");
  }).join("\n\n");

  /** The study's text with the changes; null where a table is written in another way. */
  const edited = (text, changes) => {
    if (changes.some(change => change.inCase)) return null;
    const lines = text.split("\n");
    for (const { path, values, mayBeNew } of changes) {
      const start = lines.findIndex(line => headerLine(path).test(line));
      if (start < 0) {
        if (!mayBeNew) return null;
        lines.push("", ...snippet([{ path, values }]).split("\n"), "");
        continue;
      }
      for (const [key, value] of Object.entries(values)) {
        const rest = lines.slice(start + 1), next = rest.findIndex(line => /^\s*\[/.test(line));
        const end = next < 0 ? lines.length : start + 1 + next;
        const own = new RegExp(`^\\s*(?:${literal(key)}|"${literal(key)}")\\s*=`);
        const at = lines.findIndex((line, k) => k > start && k < end && own.test(line));
        if (at < 0) lines.splice(start + 1, 0, `${bare(key)} = ${value}`);
        else lines[at] = `${bare(key)} = ${value}`;
      }
    }
    return lines.join("\n");
  };

  return { snippet, edited };
})();
