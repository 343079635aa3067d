// The page of `mesotex report`.

import { Dome } from "./dome.js";
import { readDescription, readNumbers } from "./numbers.js";
import { Player } from "./player.js";
import { unpackSample } from "./sample.js";

async function openReport() {
  const about = readDescription("description");
  for (const figure of document.querySelectorAll(".player")) {
    new Player(figure, about.sequences[Number(figure.dataset.sequence)]);
  }
  if (about.sample) {
    const groups = unpackSample(about.sample, await readNumbers("numbers"));
    window.dome = new Dome(about.sample, groups);
  }
  document.body.dataset.ready = "yes";
}

openReport();
