// SPDX-License-Identifier: Apache-2.0
import { expect, it, vi } from 'vitest';
import type { GraphNode } from '../graph/nodes';
import type { View } from '../view/view';
import { foundItems, searchItems, type Searched } from './search_items';

function page(more: Partial<Searched> = {}): Searched {
  return {
    view: undefined,
    views: [],
    nodes: [],
    datasets: [],
    commands: [],
    showView: vi.fn(),
    showNode: vi.fn(),
    viewData: vi.fn(),
    ...more,
  };
}

it('finds by words of the label or the group, in any order, those first that begin with the first word', () => {
  const commands = ['Save the graph', 'Run the graph', 'Graph anew'].map((label) => ({
    ...{ label, keys: '', run: vi.fn() },
  }));
  const items = searchItems(page({ commands, datasets: [{ name: 'graphite', typeText: 'Volume' }] }));
  const labels = (typed: string): string[] => foundItems(items, typed).map(({ label }) => label);
  expect(labels('graph')).toEqual(['Graph anew', 'Save the graph', 'Run the graph', 'graphite']);
  expect(labels('graph save')).toEqual(['Save the graph']);
  expect(labels('DATA')).toEqual(['graphite']);
  expect(labels('no such thing')).toEqual([]);
});

it('does with what was chosen what its group says', () => {
  const [showView, showNode, viewData, addData] = [vi.fn(), vi.fn(), vi.fn(), vi.fn()];
  const node = { id: 'Datasets/n', name: 'n', section: 'Datasets', role: 'source', inputs: [], entry: {} };
  const view = { title: 'g / v', content: 'v' } as unknown as View;
  const items = searchItems(
    page({
      ...{ nodes: [node as unknown as GraphNode], views: [view] },
      ...{ datasets: [{ name: 'd', typeText: 'Volume' }], showView, showNode, viewData, addData },
    }),
  );
  expect(items.map(({ group, label }) => `${group}/${label}`)).toEqual([
    'Nodes/n',
    'Views/g / v',
    'Data: show in a view/d',
    'Data: add to the graph/d',
  ]);
  for (const { run } of items) run();
  expect([showNode, showView, viewData, addData].map(({ mock }) => mock.calls)).toEqual([
    [['Datasets/n']],
    [[view]],
    [['d']],
    [['d']],
  ]);
});

it('offers the keys of the view in front, and does what they do', () => {
  const hold = vi.fn();
  const view = { hold, status: { held: false } } as unknown as View;
  const [item] = foundItems(searchItems(page({ view })), 'hold the picture');
  expect(item?.help).toBe('key k in a view');
  item?.run();
  expect(hold.mock.calls).toEqual([[true]]);
  expect(searchItems(page())).toEqual([]);
});
