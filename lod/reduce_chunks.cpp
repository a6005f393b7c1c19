#include <recede/geometry/error.h>
#include <recede/lod/detail/chunk_ladder.h>
#include <recede/lod/detail/reduce_chunks.h>
#include <recede/lod/detail/soup_pieces.h>

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <tuple>

namespace recede::detail {
namespace {

/// A pass leaves at least this share of the faces: borders of chunks then hardly count.
constexpr double k_pass_share = 0.25;
/// Each rung has this share of the faces of the one before; the last one, of what a pass leaves on average.
constexpr double k_rung_step = 0.75, k_least_of_mean = 0.1;
/// So many times the faces that are wanted are simplified as a whole at the end, past the borders of chunks.
constexpr double k_end_factor = 1.5;
/// A pass that leaves more than this share gets nowhere.
constexpr double k_stuck_share = 0.95;

/// A rung on the disk. The first of each chunk is the chunk itself, and isn't there.
struct StoredRung {
  std::size_t faces = 0;
  double cost = 0;
  ScratchFile::Extent extent;
};

/// One pass over all chunks.
class Pass {
 public:
  Pass(const ChunkFiles& from, std::size_t goal, double side, const ChunkLimits& limits,
       const SimplifyOptions& options)
      : from_(from),
        goal_(goal),
        side_(side),
        options_(options),
        file_(limits.folder),
        taken_(from.n_chunks(), 0),
        n_faces_(from.n_faces()) {
    const double share = static_cast<double>(goal) / static_cast<double>(n_faces_);
    least_share_ = std::min(k_rung_step * k_rung_step, k_least_of_mean * share);
  }

  void run(Progress* progress) {
    for (std::size_t i = 0; i < from_.n_chunks(); ++i) {
      report_progress(progress, "reduce", static_cast<double>(i) / static_cast<double>(from_.n_chunks()));
      store_ladder(i);
    }
    take_cheapest_steps();
  }

  std::size_t n_faces() const { return n_faces_; }

  /// Calls `visit(PolygonSoup)` with what is left of each chunk.
  template <typename Visit>
  void each_chunk(Visit&& visit) const {
    for (std::size_t i = 0; i < from_.n_chunks(); ++i) {
      if (taken_[i] == 0) {
        visit(from_.load(i).soup);
        continue;
      }
      PolygonSoup soup = soup_from_bytes(file_.read(ladders_[i][taken_[i]].extent));
      soup.materials = materials_;
      visit(std::move(soup));
    }
  }

 private:
  void store_ladder(std::size_t number) {
    std::vector<StoredRung>& stored = ladders_.emplace_back();
    stored.push_back({from_.n_faces(number), 0, {}});
    Chunk chunk = from_.load(number);
    if (chunk.soup.n_faces() == 0) return;
    materials_ = chunk.soup.materials;
    const std::vector<Rung> rungs = make_ladder(std::move(chunk), k_rung_step, least_share_, side_, options_);
    // The chunk itself needn't be there twice, unless faces were.
    const std::size_t first = rungs.front().soup.n_faces() < from_.n_faces(number) ? 0 : 1;
    for (std::size_t i = first; i < rungs.size(); ++i)
      stored.push_back({rungs[i].soup.n_faces(), rungs[i].cost, file_.append(to_bytes(rungs[i].soup))});
  }

  /// One rung down at a time, where a face costs least.
  void take_cheapest_steps() {
    std::vector<std::tuple<double, std::size_t, std::size_t>> steps;  // cost, chunk, rung
    for (std::size_t i = 0; i < ladders_.size(); ++i) {
      for (std::size_t rung = 1; rung < ladders_[i].size(); ++rung)
        steps.emplace_back(ladders_[i][rung].cost, i, rung);
    }
    std::sort(steps.begin(), steps.end());
    for (const auto& [cost, chunk, rung] : steps) {
      if (n_faces_ <= goal_) return;
      n_faces_ -= ladders_[chunk][taken_[chunk]].faces - ladders_[chunk][rung].faces;
      taken_[chunk] = rung;
    }
  }

  const ChunkFiles& from_;
  std::size_t goal_;
  double side_, least_share_ = 0;
  const SimplifyOptions& options_;
  ScratchFile file_;
  std::vector<std::vector<StoredRung>> ladders_;  // by chunk
  std::vector<std::size_t> taken_;                // by chunk: a rung
  std::vector<Material> materials_;
  std::size_t n_faces_;
};

}  // namespace

void MiddleSample::add(const PolygonSoup& piece) {
  for (std::size_t f = 0; f < piece.n_faces(); ++f) {
    if (seen_++ % stride_ == 0) points_.push_back(middle_of(piece, f));
  }
}

SpaceCells MiddleSample::cells(std::size_t most_faces, double share) const {
  return SpaceCells(points_, most_faces / stride_, share);
}

ReducedSurface reduce_chunks(const ChunkFiles& input, std::size_t most_faces, double side,
                             const ChunkLimits& limits, const SimplifyOptions& options, Progress* progress) {
  ReducedSurface result;
  const auto room = static_cast<std::size_t>(k_end_factor * static_cast<double>(most_faces));
  std::unique_ptr<ChunkFiles> own;
  const ChunkFiles* from = &input;
  for (std::size_t before = from->n_faces(); before > room; before = from->n_faces()) {
    const std::size_t goal =
        std::max(room, static_cast<std::size_t>(k_pass_share * static_cast<double>(before)));
    Pass pass(*from, goal, side, limits, options);
    pass.run(progress);
    ++result.passes;
    if (pass.n_faces() > goal &&
        static_cast<double>(pass.n_faces()) > k_stuck_share * static_cast<double>(before)) {
      throw InputError(fmt::format("can't be brought to {} faces, as many as memory allows: {} are left",
                                   most_faces, pass.n_faces()));
    }
    MiddleSample sample(pass.n_faces());
    pass.each_chunk([&](const PolygonSoup& soup) { sample.add(soup); });
    // No plane of this pass is one of the next.
    const double share = result.passes % 2 == 0 ? 0.5 : 0.37;
    auto next = std::make_unique<ChunkFiles>(limits.folder, sample.cells(limits.faces, share), limits.buffer);
    pass.each_chunk([&](const PolygonSoup& soup) { next->add(soup); });
    next->finish();
    own = std::move(next);
    from = own.get();
  }
  for (std::size_t i = 0; i < from->n_chunks(); ++i) append(result.soup, from->load(i).soup);
  SimplifyOptions to_end = options;
  to_end.target = {.faces = most_faces};
  to_end.prove_error = false;
  result.soup = simplify(result.soup, to_end, progress).soup;
  return result;
}

}  // namespace recede::detail
