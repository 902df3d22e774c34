"use strict";

// The walk as pure functions of the automaton, as page.py writes it. A letter is a list of truth
// values, one a proposition; a cube is a list of [proposition, value]. The tests compare every
// function with its Python counterpart.

const Walk = {
  holds(guard, letter) {
    return guard.some((cube) => cube.every(([p, value]) => letter[p] === Boolean(value)));
  },

  // The number of the edge that reads `letter` in `state`.
  edge(automaton, state, letter) {
    return automaton.edges.findIndex((e) => e.source === state && Walk.holds(e.cubes, letter));
  },

  // Where `letter` may lead: without a jump first, then by each; what is lost only if all is.
  options(automaton, state, letter) {
    const readers = [{ reader: state, jump: null }];
    automaton.jumps.forEach(([from, to], jump) => {
      if (from === state) readers.push({ reader: to, jump });
    });
    const all = readers.map(({ reader, jump }) => {
      const edge = Walk.edge(automaton, reader, letter);
      return { state: automaton.edges[edge].target, edge, jump };
    });
    const live = all.filter((option, i) => option.state !== automaton.sink
      && all.findIndex((other) => other.state === option.state) === i);
    return live.length ? live : all.slice(0, 1);
  },

  // Accepting states among those after each letter.
  visits(automaton, steps) {
    return steps.filter((step) => automaton.accepting.includes(step.state)).length;
  },

  // A letter of a guard, with as few propositions as its cubes allow.
  example(automaton, cubes) {
    const count = (cube) => cube.filter(([, value]) => value).length;
    const least = cubes.reduce((one, other) => (count(other) < count(one) ? other : one));
    const letter = automaton.propositions.map(() => false);
    least.forEach(([p, value]) => { letter[p] = Boolean(value); });
    return letter;
  },

  // `{a, b}`, with names in quotes where they need them.
  text(automaton, letter) {
    return `{${automaton.quoted.filter((_, p) => letter[p]).join(", ")}}`;
  },

  // A word as `check` prints it, or `a & !b; cycle{c}`: { letters, loop }. Throws an Error.
  parse(automaton, text) {
    const pattern = new RegExp(
      "\\s*(?:(then\\s+for\\s+ever\\b|for\\s+ever\\b|cycle\\s*\\{)"
      + '|("(?:[^"\\\\]|\\\\.)*")|(&&|[{}();,|&!¬~])|([^\\s{}();,|&!¬~"]+)|(\\S))', "gy");
    const kinds = ["", "loop", "quoted", "sign", "name", "odd"];
    const tokens = [];
    for (let m = pattern.exec(text); m !== null; m = pattern.exec(text)) {
      const kind = kinds.findIndex((_, i) => i > 0 && m[i] !== undefined);
      tokens.push({ kind: kinds[kind], text: m[kind] });
    }
    return new WordReader(automaton, tokens).word();
  },
};

class WordReader {
  constructor(automaton, tokens) {
    this.names = automaton.propositions;
    this.tokens = tokens;
    this.at = 0;
  }

  get token() {
    return this.tokens[this.at];
  }

  taken(kind, text) {
    const token = this.token;
    if (!token || token.kind !== kind || (text !== undefined && token.text !== text)) return null;
    this.at += 1;
    return token;
  }

  word() {
    const letters = this.letters(null);
    let loop = [];
    const opened = this.taken("loop");
    if (opened) {
      const braced = opened.text.endsWith("{");
      loop = this.letters(braced ? "}" : null);
      if (!loop.length) throw new Error("nothing is repeated: write at least one letter, as {}");
      if (braced && !this.taken("sign", "}")) throw new Error("`cycle{` is never closed");
    }
    if (this.token) throw new Error(`\`${this.token.text}\` cannot stand here`);
    return { letters, loop };
  }

  letters(until) {
    const found = [];
    let parted = true; // whether a letter without braces may begin here
    while (this.token && this.token.kind !== "loop") {
      if (this.token.kind === "sign" && this.token.text === until) break;
      if (this.taken("sign", ";")) {
        if (parted) found.push(this.names.map(() => false));
        parted = true;
      } else if (this.taken("sign", "{")) {
        found.push(this.letter(true));
        parted = Boolean(this.taken("sign", ";"));
      } else if (parted) {
        found.push(this.letter(false));
        parted = Boolean(this.taken("sign", ";"));
      } else {
        throw new Error(`\`${this.token.text}\` cannot stand here: part letters with \`;\``);
      }
    }
    return found;
  }

  letter(braced) {
    const signs = new Map();
    while (this.token && this.token.kind !== "loop") {
      if (this.token.kind === "sign" && "{};".includes(this.token.text)) break;
      if (this.token.kind === "sign" && [",", "&", "&&"].includes(this.token.text)) {
        this.at += 1;
        continue;
      }
      let sign = true;
      while (this.token && ["!", "¬", "~"].includes(this.token.text)) {
        sign = !sign;
        this.at += 1;
      }
      this.literal(signs, sign);
    }
    if (braced && !this.taken("sign", "}")) throw new Error("`{` is never closed");
    return this.names.map((name) => signs.get(name) === true);
  }

  literal(signs, sign) {
    const token = this.token;
    if (!token) throw new Error("a proposition is missing");
    if (token.kind === "odd") throw new Error("a quote is never closed");
    if (token.kind !== "name" && token.kind !== "quoted") {
      throw new Error(`\`${token.text}\` is no proposition`);
    }
    this.at += 1;
    let name = token.text;
    if (token.kind === "quoted") {
      name = name.slice(1, -1).replace(/\\(.)/g, "$1");
    } else if (["true", "1"].includes(name) && !this.names.includes(name) && sign) {
      return;
    }
    if (!this.names.includes(name)) {
      throw new Error(`unknown proposition \`${name}\`; there are ${this.names.join(", ")}`);
    }
    if (signs.has(name) && signs.get(name) !== sign) {
      throw new Error(`\`${name}\` cannot hold and not hold in one letter`);
    }
    signs.set(name, sign);
  }
}
