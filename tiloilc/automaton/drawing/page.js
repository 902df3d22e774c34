"use strict";

// What is on the page. `steps` are the letters read, each with where it led; `waiting` are letters
// of a pasted word that are still to be read; `loop` is what it repeats. Everything shown follows
// from these: `show` draws it anew after each change.

const automaton = JSON.parse(document.getElementById("automaton").textContent);
const letter = automaton.propositions.map(() => false);
let steps = [];
let waiting = [];
let loop = [];
let asked = null; // the letter at which a choice is to be made

const find = (id) => document.getElementById(id);
const here = () => (steps.length ? steps[steps.length - 1].state : automaton.initial);

function element(name, properties, ...children) {
  const made = Object.assign(document.createElement(name), properties);
  made.append(...children);
  return made;
}

function named(state) {
  if (state === automaton.sink) return "lost";
  const about = automaton.states[state];
  const stage = about.stage === null ? "" : `, stage ${about.stage}`;
  const accepting = automaton.accepting.includes(state) ? ", accepting" : "";
  return `state ${state}${stage}${accepting}`;
}

// Reading: one letter, or all that wait, until there is a choice to be made.

function read(chosen) {
  const options = Walk.options(automaton, here(), chosen);
  if (options.length > 1) {
    asked = chosen;
  } else {
    go(chosen, options[0]);
  }
}

function go(chosen, option) {
  asked = null;
  steps.push({ letter: chosen.slice(), source: here(), ...option });
}

function readWaiting() {
  while (waiting.length && !asked) read(waiting.shift());
  show();
}

function readOne(chosen) {
  waiting = [];
  read(chosen);
  show();
}

function readWord() {
  try {
    const word = Walk.parse(automaton, find("word").value);
    waiting = [...word.letters, ...word.loop];
    loop = word.loop;
    asked = null;
    find("fault").textContent = "";
    readWaiting();
  } catch (fault) {
    find("fault").textContent = fault.message;
  }
}

function repeat() {
  waiting = [...waiting, ...loop];
  readWaiting();
}

function back(count) {
  steps = steps.slice(0, count);
  asked = null;
  waiting = [];
  show();
}

// Showing.

function show() {
  showPicture();
  showState();
  showLetter();
  showChoice();
  showAhead();
  showPath();
}

function mark(kind, number, name) {
  document.querySelectorAll(`.ldba g[data-${kind}="${number}"]`).forEach((group) => {
    group.classList.add(name);
  });
}

function markStep(step, name) {
  const edge = automaton.edges[step.edge];
  if (step.jump !== null) mark("jump", step.jump, name);
  if (edge.target === automaton.sink) mark("lost", edge.source, name);
  else if (edge.target === edge.source) mark("loop", edge.source, name);
  else mark("edge", step.edge, name);
}

function showPicture() {
  document.querySelectorAll(".ldba g").forEach((group) => {
    group.classList.remove("now", "passed", "last");
  });
  steps.forEach((step) => markStep(step, "passed"));
  if (steps.length) markStep(steps[steps.length - 1], "last");
  if (here() === automaton.sink && steps.length) {
    const end = steps.find((step) => step.state === automaton.sink);
    mark("lost", automaton.edges[end.edge].source, "now");
  } else {
    mark("state", here(), "now");
  }
}

function showState() {
  const state = here();
  const about = automaton.states[state];
  const lost = state === automaton.sink;
  const visits = Walk.visits(automaton, steps);
  document.body.classList.toggle("is-lost", lost);
  document.body.classList.toggle("is-accepting", automaton.accepting.includes(state));
  find("where").textContent = lost ? "lost for ever" : named(state);
  find("told").textContent = lost ? "No word that begins like this is accepted." : about.told;
  find("name").textContent = lost ? "" : about.name;
  find("count").textContent = `${steps.length} letter${steps.length === 1 ? "" : "s"} read, `
    + `${visits} accepting visit${visits === 1 ? "" : "s"}`;
  find("back").disabled = find("reset").disabled = !steps.length && !asked;
}

function showLetter() {
  document.querySelectorAll("#letter button").forEach((button, p) => {
    button.setAttribute("aria-pressed", String(letter[p]));
  });
  const options = Walk.options(automaton, here(), letter);
  find("read").textContent = `Read ${Walk.text(automaton, letter)}`;
  find("leads").textContent = `leads to ${options.map((option) => named(option.state)
    + (option.jump === null ? "" : " by an ε-jump")).join(", or to ")}`;
  find("repeat").hidden = !loop.length;
}

function showChoice() {
  const box = find("choice");
  box.hidden = !asked;
  box.replaceChildren();
  if (!asked) return;
  box.append(element("p", {}, `${Walk.text(automaton, asked)} gives a choice:`));
  Walk.options(automaton, here(), asked).forEach((option) => {
    const how = option.jump === null ? "go on without a jump" : "ε-jump";
    const button = element("button", {
      type: "button",
      onclick: () => { go(asked, option); readWaiting(); },
    }, element("b", {}, `${how}: ${named(option.state)}`), " ", automaton.states[option.state].name);
    box.append(button);
  });
  box.querySelector("button").focus();
}

// What leads on from here: a click reads a letter of the guard.
function showAhead() {
  const list = find("ahead");
  list.replaceChildren();
  const state = here();
  if (state === automaton.sink) return;
  const readers = [[state, ""], ...automaton.jumps.filter(([from]) => from === state)
    .map(([, to]) => [to, `ε-jump to ${to}: `])];
  readers.forEach(([reader, how]) => automaton.edges.forEach((edge) => {
    if (edge.source !== reader || (how && edge.target === automaton.sink)) return;
    const stays = edge.target === state && !how;
    const where = stays ? "stays" : edge.target === automaton.sink ? "lost for ever"
      : named(edge.target);
    const row = element("button", {
      type: "button",
      className: edge.target === automaton.sink ? "away" : "",
      onclick: () => {
        const example = Walk.example(automaton, edge.cubes);
        example.forEach((value, p) => { letter[p] = value; });
        show();
      },
    }, how, element("code", {}, edge.guard), ` → ${where}`);
    list.append(element("li", {}, row));
  }));
}

function showPath() {
  const list = find("path");
  list.replaceChildren(...steps.map((step, t) => {
    const accepting = automaton.accepting.includes(step.state);
    const lost = step.state === automaton.sink;
    const button = element("button", {
      type: "button",
      title: "go back to this step",
      className: lost ? "away" : accepting ? "accepting" : "",
      onclick: () => back(t + 1),
    }, `${t}  `, element("code", {}, Walk.text(automaton, step.letter)),
    `${step.jump === null ? "" : " ε"} → ${named(step.state)}`);
    return element("li", {}, button);
  }));
  list.scrollTop = list.scrollHeight;
}

// Beginning.

automaton.propositions.forEach((name, p) => {
  find("letter").append(element("button", {
    type: "button",
    title: p < 9 ? `key ${p + 1}` : "",
    onclick: () => { letter[p] = !letter[p]; show(); },
  }, name));
});
find("read").onclick = () => readOne(letter);
find("run").onclick = readWord;
find("repeat").onclick = repeat;
find("back").onclick = () => back(asked ? steps.length : steps.length - 1);
find("reset").onclick = () => back(0);

document.addEventListener("keydown", (event) => {
  const typing = ["TEXTAREA", "INPUT"].includes(event.target.tagName);
  if (event.target.id === "word" && event.key === "Enter" && !event.shiftKey) {
    event.preventDefault();
    readWord();
  }
  if (typing || event.ctrlKey || event.metaKey || event.altKey) return;
  const digit = Number(event.key);
  if (digit >= 1 && digit <= automaton.propositions.length) {
    letter[digit - 1] = !letter[digit - 1];
    show();
  } else if (event.key === "Enter" && event.target.tagName !== "BUTTON") {
    readOne(letter);
  } else if (event.key === "Backspace" && (steps.length || asked)) {
    event.preventDefault();
    back(asked ? steps.length : steps.length - 1);
  } else if (event.key === "Escape") {
    back(0);
  }
});

show();
