// SPDX-License-Identifier: Apache-2.0
// What only shows: the box of the data with its extents, the directions of the axes, and the point that was picked. The arithmetic is that of
// core/annotate/annotations.cpp.
import type { Box } from '../view/camera';
import type { Vec3 } from '../view/vector';
import { numberTexts } from './legend';
import { middleOf } from './plane';
import { type Point, project, projectLine, type Projection } from './projection';

const AXES = ['x', 'y', 'z'] as const;
const FONT = 12;

interface Edge {
  readonly axis: number;
  readonly isOuter: boolean; // on the silhouette of the box
  readonly line: readonly [Point, Point];
}

/** The edges of the box that nothing inside it can hide: those of the faces that face the viewer. */
export function edgesInFront(view: Projection, box: Box): readonly Edge[] {
  const faces = (axis: 0 | 1 | 2, end: 0 | 1): boolean => {
    if (view.isParallel) return end === 1 ? view.forward[axis] < 0 : view.forward[axis] > 0;
    return end === 1 ? view.eye[axis] > box[1][axis] : view.eye[axis] < box[0][axis];
  };
  return ([0, 1, 2] as const).flatMap((axis) =>
    ([0, 1] as const).flatMap((endU) =>
      ([0, 1] as const).flatMap((endV): Edge[] => {
        const [u, v] = [((axis + 1) % 3) as 0 | 1 | 2, ((axis + 2) % 3) as 0 | 1 | 2];
        const [isSeenU, isSeenV] = [faces(u, endU), faces(v, endV)];
        if (!isSeenU && !isSeenV) return [];
        const end = (along: 0 | 1): Vec3 => {
          const point: [number, number, number] = [0, 0, 0];
          point[axis] = box[along][axis];
          point[u] = box[endU][u];
          point[v] = box[endV][v];
          return point;
        };
        const line = projectLine(view, end(0), end(1));
        return line ? [{ axis, isOuter: isSeenU !== isSeenV, line }] : [];
      }),
    ),
  );
}

const lower = (edge: Edge): number => edge.line[0].y + edge.line[1].y;

export function BoxMark({ view, box }: { readonly view: Projection; readonly box: Box }) {
  const edges = edgesInFront(view, box);
  const middle = project(view, middleOf(box)) ?? { x: view.size.width / 2, y: view.size.height / 2 };
  const lowest = [0, 1, 2].flatMap((axis) => {
    const outer = edges.filter((edge) => edge.axis === axis && edge.isOuter);
    return outer.sort((a, b) => lower(b) - lower(a)).slice(0, 1);
  });
  const d = edges.map(({ line: [a, b] }) => `M${a.x} ${a.y}L${b.x} ${b.y}`).join('');
  return (
    <g className="box-mark">
      <path className="halo" d={d} />
      <path className="line" d={d} />
      {lowest.map((edge) => (
        <Extents key={edge.axis} {...{ edge, box, middle, width: view.size.width }} />
      ))}
    </g>
  );
}

/** The numbers at the ends of an edge, and its axis' name, on the side away from the box. */
function Extents({ edge, box, middle, width }: { edge: Edge; box: Box; middle: Point; width: number }) {
  const [from, to] = edge.line;
  const way = { x: to.x - from.x, y: to.y - from.y };
  const length = Math.hypot(way.x, way.y);
  if (length < 5 * FONT) return null;
  let out = { x: way.y / length, y: -way.x / length };
  if (out.x * ((from.x + to.x) / 2 - middle.x) + out.y * ((from.y + to.y) / 2 - middle.y) < 0)
    out = { x: -out.x, y: -out.y };
  const axis = edge.axis as 0 | 1 | 2;
  const [lo, hi] = [box[0][axis], box[1][axis]];
  const [first = '', last = ''] = numberTexts([lo, hi], hi - lo);
  const anchor = out.x > 0.5 ? 'start' : out.x < -0.5 ? 'end' : 'middle';
  return [first, AXES[axis], last].map((text, i) => {
    const along = [0.12, 0.5, 0.88][i] ?? 0;
    const room = 0.62 * FONT * text.length + 2; // so that no digit is cut off by the picture's edge
    const wanted = from.x + along * way.x + 0.6 * FONT * out.x;
    const x =
      anchor === 'end'
        ? Math.max(room, wanted)
        : anchor === 'start'
          ? Math.min(width - room, wanted)
          : wanted;
    const y = from.y + along * way.y + 0.6 * FONT * out.y + (0.35 + 0.45 * out.y) * FONT;
    return (
      <text key={i} x={x} y={y} textAnchor={anchor}>
        {text}
      </text>
    );
  });
}

const LENGTH = 26;
const CORNER = 46; // pixels from the picture's lower left corner

/** The directions of x, y and z in the lower left corner. */
export function AxesMark({ view }: { readonly view: Projection }) {
  const { width, height } = view.size;
  if (Math.min(width, height) < 3 * CORNER) return null;
  const at = { x: CORNER, y: height - CORNER };
  const order = ([0, 1, 2] as (0 | 1 | 2)[]).sort((a, b) => view.forward[b] - view.forward[a]); // the farthest tip first
  return (
    <g className="axes-mark">
      {order.map((axis) => {
        const [x, y] = [view.right[axis] * LENGTH, -view.up[axis] * LENGTH];
        const d = `M${at.x} ${at.y}L${at.x + x} ${at.y + y}`;
        return (
          <g key={axis} className={`axis-${AXES[axis]}`}>
            <path className="halo" d={d} />
            <path className="line" d={d} />
            <text x={at.x + 1.45 * x} y={at.y + 1.45 * y + 4} textAnchor="middle">
              {AXES[axis]}
            </text>
          </g>
        );
      })}
    </g>
  );
}

/** The point that was picked. */
export function PickMark({ view, point }: { readonly view: Projection; readonly point: Vec3 }) {
  const at = project(view, point);
  if (!at) return null;
  return (
    <g className="pick-mark">
      <circle className="halo" cx={at.x} cy={at.y} r={7} />
      <circle className="line" cx={at.x} cy={at.y} r={7} />
      <circle className="dot" cx={at.x} cy={at.y} r={2} />
    </g>
  );
}
