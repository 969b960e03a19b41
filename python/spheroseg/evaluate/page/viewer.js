// SPDX-License-Identifier: GPL-3.0-or-later
"use strict";

const VERTEX_SHADER = `#version 300 es
in vec3 position;
in float label;
uniform mat4 view;
uniform vec3 scale;
uniform float pointSize;
out vec3 seen;
flat out float ownLabel;
void main() {
    vec4 place = view * vec4(position, 1.0);
    seen = place.xyz / scale;
    ownLabel = label;
    gl_Position = place;
    gl_PointSize = pointSize;
}`;

// mode 0: shaded colour of the label; 1: the label itself, for picking; 2: one plain colour.
const FRAGMENT_SHADER = `#version 300 es
precision highp float;
precision highp sampler2D;
in vec3 seen;
flat in float ownLabel;
uniform int mode;
uniform float picked;
uniform vec4 plain;
uniform sampler2D colours;
out vec4 colour;
void main() {
    int label = int(ownLabel + 0.5);
    if (mode == 2) { colour = plain; return; }
    if (mode == 1) {
        int code = label + 1;
        colour = vec4(float(code & 255), float((code >> 8) & 255), float(code >> 16), 255.0) / 255.0;
        return;
    }
    vec3 normal = normalize(cross(dFdx(seen), dFdy(seen)));
    float light = 0.45 + 0.55 * abs(normal.z);
    vec3 own = texelFetch(colours, ivec2(label & 255, label >> 8), 0).rgb;
    if (picked >= 0.0) own = float(label) == picked ? vec3(1.0, 0.95, 0.3) : mix(own, vec3(0.8), 0.6);
    colour = vec4(own * light, 1.0);
}`;

/** Turns base64 of gzip into an ArrayBuffer. */
async function unpack(text) {
    const raw = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
    const stream = new Blob([raw]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Response(stream).arrayBuffer();
}

class Viewer {
    constructor(root) {
        this.root = root;
        this.canvas = root.querySelector("canvas");
        this.note = root.querySelector("output");
        this.gl = this.canvas.getContext("webgl2", {antialias: true, preserveDrawingBuffer: true});
        if (!this.gl) throw new Error("this browser has no WebGL 2");
        this.picked = -1;
        this.rotation = [1, 0, 0, 0, 1, 0, 0, 0, 1];
        this.zoom = 0.95; // of the radius around the mesh, so that no turn cuts it off
        this.pointers = new Map();
        this.build();
        this.listen();
    }

    build() {
        const gl = this.gl;
        this.program = gl.createProgram();
        for (const [kind, source] of [[gl.VERTEX_SHADER, VERTEX_SHADER],
                                      [gl.FRAGMENT_SHADER, FRAGMENT_SHADER]]) {
            const shader = gl.createShader(kind);
            gl.shaderSource(shader, source);
            gl.compileShader(shader);
            if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) {
                throw new Error(gl.getShaderInfoLog(shader));
            }
            gl.attachShader(this.program, shader);
        }
        gl.bindAttribLocation(this.program, 0, "position");
        gl.bindAttribLocation(this.program, 1, "label");
        gl.linkProgram(this.program);
        gl.useProgram(this.program);
        this.at = {};
        for (const name of ["view", "scale", "pointSize", "mode", "picked", "plain", "colours"]) {
            this.at[name] = gl.getUniformLocation(this.program, name);
        }
        this.buffers = {};
        for (const name of ["corners", "labels", "lines", "points"]) {
            this.buffers[name] = gl.createBuffer();
        }
        this.texture = gl.createTexture();
        gl.enable(gl.DEPTH_TEST);
        gl.clearColor(1, 1, 1, 1);
    }

    listen() {
        const canvas = this.canvas;
        canvas.addEventListener("pointerdown", (event) => {
            canvas.setPointerCapture(event.pointerId);
            this.pointers.set(event.pointerId, [event.offsetX, event.offsetY]);
            this.moved = 0;
        });
        canvas.addEventListener("pointermove", (event) => this.drag(event));
        for (const name of ["pointerup", "pointercancel"]) {
            canvas.addEventListener(name, (event) => {
                if (!this.pointers.delete(event.pointerId)) return;
                if (name === "pointerup" && this.moved < 4) this.pick(event.offsetX, event.offsetY);
            });
        }
        canvas.addEventListener("wheel", (event) => {
            event.preventDefault();
            this.scale(Math.exp(-0.001 * event.deltaY));
        }, {passive: false});
        canvas.addEventListener("keydown", (event) => {
            const turn = {ArrowLeft: [-0.15, 0], ArrowRight: [0.15, 0],
                          ArrowUp: [0, -0.15], ArrowDown: [0, 0.15]}[event.key];
            if (turn) this.turn(...turn);
            else if (event.key === "+" || event.key === "=") this.scale(1.1);
            else if (event.key === "-") this.scale(1 / 1.1);
            else return;
            event.preventDefault();
        });
        new ResizeObserver(() => this.draw()).observe(canvas);
    }

    drag(event) {
        const before = this.pointers.get(event.pointerId);
        if (!before) return;
        const now = [event.offsetX, event.offsetY];
        this.moved += Math.hypot(now[0] - before[0], now[1] - before[1]);
        if (this.pointers.size === 1) {
            this.turn(0.01 * (now[0] - before[0]), 0.01 * (now[1] - before[1]));
        } else {
            for (const [id, other] of this.pointers) {
                if (id === event.pointerId) continue;
                const distance = (p) => Math.hypot(p[0] - other[0], p[1] - other[1]) + 1;
                this.scale(distance(now) / distance(before));
            }
        }
        this.pointers.set(event.pointerId, now);
    }

    turn(aroundY, aroundX) {
        const [cy, sy, cx, sx] = [Math.cos(aroundY), Math.sin(aroundY), Math.cos(aroundX), Math.sin(aroundX)];
        const step = [cy, 0, sy, sx * sy, cx, -sx * cy, -cx * sy, sx, cx * cy];
        const old = this.rotation;
        this.rotation = step.map((_, i) => {
            const row = 3 * Math.floor(i / 3), column = i % 3;
            return step[row] * old[column] + step[row + 1] * old[3 + column] + step[row + 2] * old[6 + column];
        });
        this.draw();
    }

    scale(factor) {
        this.zoom = Math.min(40, Math.max(0.3, this.zoom * factor));
        this.draw();
    }

    /** Shows a mesh: positions (3 V floats) and corners (3 F indices). */
    setMesh(positions, corners) {
        this.positions = positions;
        this.corners = corners;
        const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
        positions.forEach((value, i) => {
            low[i % 3] = Math.min(low[i % 3], value);
            high[i % 3] = Math.max(high[i % 3], value);
        });
        this.centre = low.map((value, i) => (value + high[i]) / 2);
        this.radius = 0;
        for (let i = 0; i < positions.length; i += 3) {
            const distance = Math.hypot(...this.centre.map((value, j) => positions[i + j] - value));
            this.radius = Math.max(this.radius, distance);
        }
        this.radius ||= 1;
        this.upload("corners", this.gather(corners));
    }

    /** Shows a labelling of the mesh; `lines` and `bowties` are vertex indices. */
    setLabels(labels, palette, counts, lines, bowties) {
        const gl = this.gl;
        this.labels = labels;
        this.counts = counts;
        this.picked = -1;
        const perCorner = new Float32Array(3 * labels.length);
        labels.forEach((label, i) => perCorner.fill(label, 3 * i, 3 * i + 3));
        this.upload("labels", perCorner);
        this.upload("lines", this.gather(lines));
        this.upload("points", this.gather(bowties));
        this.lineCount = lines.length;
        this.pointCount = bowties.length;
        const rows = Math.ceil(palette.length / 3 / 256);
        const texels = new Uint8Array(256 * rows * 4).fill(255);
        for (let i = 0; i < palette.length / 3; i++) texels.set(palette.subarray(3 * i, 3 * i + 3), 4 * i);
        gl.bindTexture(gl.TEXTURE_2D, this.texture);
        gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, 256, rows, 0, gl.RGBA, gl.UNSIGNED_BYTE, texels);
        gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
        gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
        this.tell();
        this.draw();
    }

    gather(indices) {
        const found = new Float32Array(3 * indices.length);
        indices.forEach((vertex, i) => found.set(this.positions.subarray(3 * vertex, 3 * vertex + 3), 3 * i));
        return found;
    }

    upload(name, data) {
        this.gl.bindBuffer(this.gl.ARRAY_BUFFER, this.buffers[name]);
        this.gl.bufferData(this.gl.ARRAY_BUFFER, data, this.gl.STATIC_DRAW);
    }

    resize() {
        const ratio = window.devicePixelRatio || 1;
        const width = Math.max(1, Math.round(this.canvas.clientWidth * ratio));
        const height = Math.max(1, Math.round(this.canvas.clientHeight * ratio));
        if (this.canvas.width !== width || this.canvas.height !== height) {
            this.canvas.width = width;
            this.canvas.height = height;
        }
        this.gl.viewport(0, 0, width, height);
    }

    /** The view matrix, column by column; `nearer` lifts lines and points off the surface. */
    view(nearer) {
        const r = this.rotation, c = this.centre, size = this.zoom / this.radius;
        const aspect = this.canvas.width / this.canvas.height;
        const scale = [size / Math.max(1, aspect), size * Math.min(1, aspect), -0.5 / this.radius];
        this.gl.uniform3f(this.at.scale, ...scale);
        const matrix = new Float32Array(16);
        for (let row = 0; row < 3; row++) {
            let shift = 0;
            for (let column = 0; column < 3; column++) {
                matrix[4 * column + row] = scale[row] * r[3 * row + column];
                shift -= matrix[4 * column + row] * c[column];
            }
            matrix[12 + row] = shift;
        }
        matrix[14] -= nearer;
        matrix[15] = 1;
        return matrix;
    }

    drawTriangles(mode) {
        const gl = this.gl;
        gl.uniformMatrix4fv(this.at.view, false, this.view(0));
        gl.uniform1i(this.at.mode, mode);
        gl.uniform1f(this.at.picked, this.picked);
        gl.uniform1i(this.at.colours, 0);
        gl.bindTexture(gl.TEXTURE_2D, this.texture);
        gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
        gl.bindBuffer(gl.ARRAY_BUFFER, this.buffers.corners);
        gl.enableVertexAttribArray(0);
        gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
        gl.bindBuffer(gl.ARRAY_BUFFER, this.buffers.labels);
        gl.enableVertexAttribArray(1);
        gl.vertexAttribPointer(1, 1, gl.FLOAT, false, 0, 0);
        gl.drawArrays(gl.TRIANGLES, 0, this.corners.length);
    }

    drawPlain(name, kind, count, colour, nearer) {
        const gl = this.gl;
        gl.uniformMatrix4fv(this.at.view, false, this.view(nearer));
        gl.uniform1i(this.at.mode, 2);
        gl.uniform4f(this.at.plain, ...colour, 1);
        gl.disableVertexAttribArray(1);
        gl.bindBuffer(gl.ARRAY_BUFFER, this.buffers[name]);
        gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
        gl.drawArrays(kind, 0, count);
    }

    draw() {
        if (!this.labels) return;
        this.resize();
        this.drawTriangles(0);
        this.gl.uniform1f(this.at.pointSize, 8 * (window.devicePixelRatio || 1));
        this.drawPlain("lines", this.gl.LINES, this.lineCount, [0.1, 0.1, 0.1], 0.002);
        this.drawPlain("points", this.gl.POINTS, this.pointCount, [0.88, 0, 0], 0.004);
    }

    /** Picks the sub-mesh under a point of the canvas (CSS pixels); none beside the mesh. */
    pick(x, y) {
        const gl = this.gl, ratio = this.canvas.width / this.canvas.clientWidth;
        this.resize();
        gl.clearColor(0, 0, 0, 0);
        this.drawTriangles(1);
        const pixel = new Uint8Array(4);
        gl.readPixels(Math.round(x * ratio), this.canvas.height - 1 - Math.round(y * ratio), 1, 1,
                      gl.RGBA, gl.UNSIGNED_BYTE, pixel);
        gl.clearColor(1, 1, 1, 1);
        this.picked = pixel[0] + 256 * pixel[1] + 65536 * pixel[2] - 1;
        this.tell();
        this.draw();
    }

    tell() {
        if (this.picked < 0) {
            this.note.textContent = "Click or tap a sub-mesh to see its counts.";
            return;
        }
        const of = (name, one, many) => {
            const count = this.counts[name][this.picked];
            return `${count} ${count === 1 ? one : many}`;
        };
        this.note.textContent = `Sub-mesh ${this.picked}: ` +
            [of("triangles", "triangle", "triangles"), of("vertices", "vertex", "vertices"),
             of("edges", "boundary edge", "boundary edges"),
             of("bowties", "bowtie", "bowties")].join(", ");
    }
}

/** Fills the menus, and shows what they name. */
async function startViewer() {
    const root = document.getElementById("viewer");
    const index = JSON.parse(document.getElementById("viewer-index").textContent);
    if (!root || index.length === 0) return;
    const [meshMenu, labelMenu] = root.querySelectorAll("select");
    const viewer = new Viewer(root);
    const packed = (id) => document.getElementById(id).textContent;
    const showLabels = async () => {
        const entry = index[meshMenu.value].labellings[labelMenu.value];
        const [labels, palette, lines, bowties] = await Promise.all(
            ["labels", "palette", "lines", "bowties"].map((part) => unpack(entry[part])));
        viewer.setLabels(new Uint32Array(labels), new Uint8Array(palette), entry.counts,
                         new Uint32Array(lines), new Uint32Array(bowties));
        root.dataset.shown = entry.title;
    };
    const showMesh = async () => {
        const mesh = index[meshMenu.value];
        const [positions, corners] = await Promise.all(
            [unpack(packed(mesh.positions)), unpack(packed(mesh.corners))]);
        viewer.setMesh(new Float32Array(positions), new Uint32Array(corners));
        labelMenu.replaceChildren(...mesh.labellings.map((entry, i) => new Option(entry.title, i)));
        await showLabels();
    };
    meshMenu.replaceChildren(...index.map((mesh, i) => new Option(mesh.title, i)));
    // One after the other: of two choices the later one may be unpacked sooner.
    let shown = showMesh();
    const inTurn = (show) => () => { shown = shown.then(show, show); };
    meshMenu.addEventListener("change", inTurn(showMesh));
    labelMenu.addEventListener("change", inTurn(showLabels));
    await shown;
    window.spherosegViewer = viewer;
}

startViewer().catch((error) => {
    document.querySelector("#viewer output").textContent = `No 3D view: ${error.message}`;
});
