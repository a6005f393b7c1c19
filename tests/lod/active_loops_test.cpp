#include <recede/lod/detail/active_loops.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>

namespace recede::detail {
namespace {

// Loops over the vertices given, nothing else.
SeamGraph graph_of(const std::vector<std::vector<Index>>& loops) {
  SeamGraph graph;
  Index n_vertices = 0;
  for (const std::vector<Index>& loop : loops) {
    for (const Index vertex : loop) {
      graph.slots.push_back({Vec2(static_cast<double>(graph.slots.size()), 0), vertex, 0});
      n_vertices = std::max(n_vertices, vertex + 1);
    }
    graph.loop_offsets.push_back(static_cast<Index>(graph.slots.size()));
    graph.patch_loops.push_back(static_cast<Index>(graph.loop_offsets.size() - 1));
  }
  graph.positions.assign(n_vertices, Vec3::Zero());
  return graph;
}

std::vector<Index> slots_of(const ActiveLoops& loops, Index loop) {
  std::vector<Index> slots;
  const Index first = loops.first_of(loop);
  if (first == k_no_index) return slots;
  Index slot = first;
  do {
    slots.push_back(slot);
    slot = loops.next(slot);
  } while (slot != first);
  std::rotate(slots.begin(), std::min_element(slots.begin(), slots.end()), slots.end());
  return slots;
}

std::multiset<Index> slots_at(const ActiveLoops& loops, Index vertex) {
  std::multiset<Index> slots;
  loops.each_slot(vertex, [&](Index slot) { slots.insert(slot); });
  return slots;
}

std::set<Index> neighbours_of(const ActiveLoops& loops, Index vertex) {
  std::set<Index> vertices;
  loops.each_neighbour(vertex, [&](Index w) { vertices.insert(w); });
  return vertices;
}

// Two triangles side by side, 0 1 2 and 2 1 3.
TEST(ActiveLoops, KnowNeighboursAndSlotsOfVertices) {
  const SeamGraph graph = graph_of({{0, 1, 2}, {2, 1, 3}});
  const ActiveLoops loops(graph);
  EXPECT_EQ(slots_at(loops, 0), (std::multiset<Index>{0}));
  EXPECT_EQ(slots_at(loops, 1), (std::multiset<Index>{1, 4}));
  EXPECT_EQ(slots_at(loops, 2), (std::multiset<Index>{2, 3}));
  EXPECT_EQ(neighbours_of(loops, 0), (std::set<Index>{1, 2}));
  EXPECT_EQ(neighbours_of(loops, 1), (std::set<Index>{0, 2, 3}));
  EXPECT_EQ(loops.previous(0), 2u);
  EXPECT_EQ(loops.next(5), 3u);
  EXPECT_EQ(loops.loop_of(3), 1u);
  EXPECT_TRUE(loops.encloses(0));
}

TEST(ActiveLoops, EncloseNothingWithTwoSlotsAndKeepThemNevertheless) {
  const SeamGraph graph = graph_of({{0, 1, 2}, {2, 1, 3}});
  ActiveLoops loops(graph);
  loops.drop(0);
  EXPECT_FALSE(loops.encloses(0));
  EXPECT_EQ(loops.size_of(0), 2u);
  EXPECT_EQ(slots_of(loops, 0), (std::vector<Index>{1, 2}));
  EXPECT_TRUE(slots_at(loops, 0).empty());
  loops.drop(1);
  EXPECT_EQ(slots_of(loops, 0), (std::vector<Index>{2}));
  EXPECT_EQ(loops.next(2), 2u);
  loops.drop(2);
  EXPECT_EQ(loops.size_of(0), 0u);
  EXPECT_EQ(loops.first_of(0), k_no_index);
  EXPECT_EQ(neighbours_of(loops, 1), (std::set<Index>{2, 3}));
  for (const Index slot : {2u, 1u, 0u}) loops.restore(slot);
  EXPECT_EQ(slots_of(loops, 0), (std::vector<Index>{0, 1, 2}));
  EXPECT_EQ(neighbours_of(loops, 1), (std::set<Index>{0, 2, 3}));
}

TEST(ActiveLoops, GiveSlotsAnotherVertex) {
  const SeamGraph graph = graph_of({{0, 1, 2}, {2, 1, 3}});
  ActiveLoops loops(graph);
  loops.give(4, 0);
  EXPECT_EQ(loops.vertex(4), 0u);
  EXPECT_EQ(slots_at(loops, 0), (std::multiset<Index>{0, 4}));
  EXPECT_EQ(slots_at(loops, 1), (std::multiset<Index>{1}));
  EXPECT_EQ(neighbours_of(loops, 0), (std::set<Index>{1, 2, 3}));
  // Of a vertex that a loop has twice in a row, it is a neighbour of its own.
  loops.give(5, 0);
  EXPECT_TRUE(neighbours_of(loops, 0).contains(0));
}

// What the loops must say, from lists that are searched through each time.
struct PlainLoops {
  std::vector<std::vector<Index>> loops;
  std::map<Index, Index> vertex_of;

  explicit PlainLoops(const SeamGraph& graph) {
    for (std::size_t l = 0; l < graph.n_loops(); ++l) {
      loops.emplace_back();
      for (Index s = graph.loop_offsets[l]; s < graph.loop_offsets[l + 1]; ++s) {
        loops.back().push_back(s);
        vertex_of[s] = graph.slots[s].vertex;
      }
    }
  }
  bool is_active(Index slot) const {
    return std::any_of(loops.begin(), loops.end(), [&](const std::vector<Index>& loop) {
      return std::find(loop.begin(), loop.end(), slot) != loop.end();
    });
  }
  // The places of slots never change, so that their order is that of their numbers.
  void drop(Index slot) {
    for (std::vector<Index>& loop : loops) std::erase(loop, slot);
  }
  void restore(Index slot, Index loop) {
    loops[loop].insert(std::lower_bound(loops[loop].begin(), loops[loop].end(), slot), slot);
  }
};

void expect_same(const ActiveLoops& loops, const PlainLoops& plain, std::size_t n_vertices) {
  std::map<Index, std::multiset<Index>> slots_of_vertex;
  std::map<Index, std::set<Index>> neighbours;
  for (Index l = 0; l < plain.loops.size(); ++l) {
    const std::vector<Index>& loop = plain.loops[l];
    ASSERT_EQ(slots_of(loops, l), loop);
    ASSERT_EQ(loops.size_of(l), loop.size());
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const Index vertex = plain.vertex_of.at(loop[i]);
      const Index before = loop[(i + loop.size() - 1) % loop.size()], after = loop[(i + 1) % loop.size()];
      ASSERT_EQ(loops.vertex(loop[i]), vertex);
      ASSERT_EQ(loops.previous(loop[i]), before);
      slots_of_vertex[vertex].insert(loop[i]);
      neighbours[vertex].insert({plain.vertex_of.at(before), plain.vertex_of.at(after)});
    }
  }
  for (Index v = 0; v < n_vertices; ++v) {
    ASSERT_EQ(slots_at(loops, v), slots_of_vertex[v]);
    ASSERT_EQ(neighbours_of(loops, v), neighbours[v]);
  }
}

TEST(ActiveLoops, AreAsPlainListsSayAfterRandomChangesAndWhenTheseAreTakenBack) {
  std::mt19937 random(4);
  for (int round = 0; round < 60; ++round) {
    constexpr Index k_vertices = 9;
    std::vector<std::vector<Index>> lists(1 + random() % 4);
    for (std::vector<Index>& list : lists) {
      list.resize(1 + random() % 9);
      for (Index& vertex : list) vertex = static_cast<Index>(random() % k_vertices);
    }
    SeamGraph graph = graph_of(lists);
    graph.positions.assign(k_vertices, Vec3::Zero());
    ActiveLoops loops(graph);
    PlainLoops plain(graph);
    struct Step {
      Index slot, before;
      bool is_drop;
    };
    std::vector<Step> steps;
    for (int i = 0; i < 40; ++i) {
      const auto slot = static_cast<Index>(random() % graph.slots.size());
      if (!loops.is_active(slot)) continue;
      steps.push_back({slot, loops.vertex(slot), random() % 2 == 0});
      if (steps.back().is_drop) {
        loops.drop(slot);
        plain.drop(slot);
      } else {
        const auto vertex = static_cast<Index>(random() % k_vertices);
        loops.give(slot, vertex);
        plain.vertex_of[slot] = vertex;
      }
      ASSERT_EQ(loops.is_active(slot), plain.is_active(slot));
      expect_same(loops, plain, k_vertices);
      if (HasFatalFailure()) return;
    }
    while (!steps.empty()) {
      const Step step = steps.back();
      steps.pop_back();
      if (step.is_drop) {
        loops.restore(step.slot);
        plain.restore(step.slot, loops.loop_of(step.slot));
      } else {
        loops.give(step.slot, step.before);
        plain.vertex_of[step.slot] = step.before;
      }
      expect_same(loops, plain, k_vertices);
      if (HasFatalFailure()) return;
    }
  }
}

}  // namespace
}  // namespace recede::detail
