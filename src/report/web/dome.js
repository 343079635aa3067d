// The sample's images, chosen by hovering over its views and lights.

import { mix, srgb, weightsOf } from "./sample.js";

const DOT = 4;

// Where a direction lies on a disc seen from above, areas kept.
function onDisc([x, y, z], side) {
  const scale = (0.5 * side - 2 * DOT) / Math.sqrt(1 + z);
  return [0.5 * side + x * scale, 0.5 * side - y * scale];
}

const degrees = (radians) => Math.round((180 * radians) / Math.PI);
const angles = ([x, y, z]) => `θ ${degrees(Math.acos(Math.min(1, z)))}°, φ ${(degrees(Math.atan2(y, x)) + 360) % 360}°`;

export class Dome {
  constructor(about, groups) {
    Object.assign(this, { about, groups, view: 0, light: 0 });
    const canvas = (id) => document.getElementById(id);
    this.image = canvas("image");
    Object.assign(this.image, { width: about.width, height: about.height });
    this.numbers = new Float32Array(3 * about.width * about.height);
    for (const name of ["view", "light"]) {
      canvas(`${name}s`).addEventListener("pointermove", (event) => this.choose(name, event));
    }
    this.show();
  }

  choose(name, { target, offsetX, offsetY }) {
    const scale = target.width / target.clientWidth;
    const list = this.about[`${name}s`];
    const away = list.map((direction) => {
      const [x, y] = onDisc(direction, target.width);
      return Math.hypot(x - scale * offsetX, y - scale * offsetY);
    });
    const nearest = away.indexOf(Math.min(...away));
    if (this.about.scattered) Object.assign(this, { view: nearest, light: nearest });
    else this[name] = nearest;
    this.show();
  }

  show() {
    const { about, view, light } = this;
    this.draw("views", about.views, view);
    this.draw("lights", about.lights, light);
    const group = this.groups[about.scattered ? 0 : view];
    this.paint(mix(group, weightsOf(group, light), this.numbers));
    document.getElementById("pair").textContent =
      `view ${angles(about.views[view])} · light ${angles(about.lights[light])}`;
  }

  draw(id, directions, chosen) {
    const canvas = document.getElementById(id), pen = canvas.getContext("2d"), side = canvas.width;
    pen.clearRect(0, 0, side, side);
    pen.strokeStyle = "#444";
    pen.beginPath();
    pen.arc(side / 2, side / 2, side / 2 - 2 * DOT, 0, 2 * Math.PI);
    pen.stroke();
    directions.forEach((direction, index) => {
      const [x, y] = onDisc(direction, side);
      pen.fillStyle = index === chosen ? "#ffd24a" : "#8fa4bd";
      pen.beginPath();
      pen.arc(x, y, index === chosen ? 1.6 * DOT : DOT, 0, 2 * Math.PI);
      pen.fill();
    });
  }

  // A white plane facing the light shows as white.
  paint(numbers) {
    const pen = this.image.getContext("2d"), picture = pen.createImageData(this.image.width, this.image.height);
    for (let i = 0; i < numbers.length / 3; i++) {
      for (let c = 0; c < 3; c++) picture.data[4 * i + c] = srgb(Math.PI * numbers[3 * i + c]);
      picture.data[4 * i + 3] = 255;
    }
    pen.putImageData(picture, 0, 0);
  }
}
