#include <recede/geometry/atomic_file.h>
#include <recede/geometry/error.h>
#include <recede/geometry/texture.h>
#include <recede/lod/detail/pmesh_chunks.h>
#include <recede/lod/detail/pmesh_numbering.h>
#include <recede/lod/pmesh.h>

#include <fmt/format.h>

#include <stdexcept>

namespace recede {

using detail::ByteStreams;
using detail::PmeshCodec;
using detail::PmeshHeader;

struct PmeshReader::State {
  std::string name;
  std::string pending;     // bytes that don't make a whole part yet
  std::size_t offset = 0;  // of `pending` in the stream
  bool has_started = false, is_complete = false;
  std::size_t n_batches = 0;  // with the base
  std::optional<PmeshHeader> header;
  std::optional<PmeshCodec> codec;
  std::optional<detail::PmeshNumbering> numbering;

  [[noreturn]] void fail(const std::string& reason) const { throw InputError::at_byte(name, offset, reason); }

  void read_start();
  bool read_chunk();
  void read_payload(std::string_view kind, std::string_view payload);
  void read_known(std::string_view kind, ByteStreams& streams);
  void read_end(std::string_view payload);
};

void PmeshReader::State::read_start() {
  const std::size_t n = std::min(pending.size(), detail::k_pmesh_magic.size());
  if (std::string_view(pending).substr(0, n) != detail::k_pmesh_magic.substr(0, n))
    fail("isn't a .pmesh file");
  if (pending.size() < detail::k_pmesh_start) return;
  const std::uint32_t version =
      detail::read_u32(std::string_view(pending).substr(detail::k_pmesh_magic.size()));
  if (version != detail::k_pmesh_version) fail(fmt::format("version {} of the format is unknown", version));
  has_started = true;
  offset = detail::k_pmesh_start;
  pending.erase(0, detail::k_pmesh_start);
}

/// False when the next part hasn't come as a whole.
bool PmeshReader::State::read_chunk() {
  if (pending.size() < detail::k_chunk_header) return false;
  const std::string kind = pending.substr(0, 4);
  const std::uint32_t size = detail::read_u32(std::string_view(pending).substr(4));
  for (const char c : kind) {
    if ((c < 'A' || c > 'Z') && c != ' ') fail("a part of an unreadable kind");
  }
  if (pending.size() - detail::k_chunk_header < size) return false;
  const std::string payload = pending.substr(detail::k_chunk_header, size);
  if (detail::crc32(kind + payload) != detail::read_u32(std::string_view(pending).substr(8))) {
    fail(fmt::format("the checksum of the part '{}' is wrong", kind));
  }
  read_payload(kind, payload);
  offset += detail::k_chunk_header + size;
  pending.erase(0, detail::k_chunk_header + size);
  return true;
}

void PmeshReader::State::read_payload(std::string_view kind, std::string_view payload) {
  if (is_complete) fail("there is something after the end");
  if (kind == detail::k_chunk_end) return read_end(payload);
  try {
    ByteStreams streams = ByteStreams::unpack(payload);
    read_known(kind, streams);
    if (!streams.all_taken()) throw std::out_of_range("a batch has bytes left over");
  } catch (const std::out_of_range& error) {
    fail(error.what());
  }
}

void PmeshReader::State::read_known(std::string_view kind, ByteStreams& streams) {
  if (!header) {
    if (kind != detail::k_chunk_head) fail("the header doesn't come first");
    PmeshCodec::code_header(streams, header.emplace(), false);
  } else if (!codec) {
    if (kind != detail::k_chunk_base) fail("the base doesn't follow the header");
    codec.emplace(*header, false).code_base(streams);
    ++n_batches;
  } else if (kind == detail::k_chunk_splits) {
    if (n_batches > header->n_batches || numbering) fail("more batches than the header says");
    codec->code_batch(streams);
    if (codec->read().splits.size() > header->n_splits) fail("more splits than the header says");
    ++n_batches;
  } else if (kind == detail::k_chunk_numbering) {
    if (!header->has_numbering || numbering || n_batches != header->n_batches + 1)
      fail("a numbering out of place");
    detail::code_numbering<false>(streams, *header, codec->table(), numbering.emplace());
    assemble(*codec, &*numbering);  // what can't be used comes to light here
  } else {
    fail(fmt::format("a part of the unknown kind '{}'", kind));
  }
}

void PmeshReader::State::read_end(std::string_view payload) {
  const bool all = codec && n_batches == header->n_batches + 1 &&
                   codec->read().splits.size() == header->n_splits &&
                   numbering.has_value() == header->has_numbering;
  if (!all || !payload.empty()) fail("the end comes too early");
  is_complete = true;
}

PmeshReader::PmeshReader(std::string name) : state_(std::make_unique<State>()) {
  state_->name = std::move(name);
}
PmeshReader::~PmeshReader() = default;

std::size_t PmeshReader::feed(std::string_view bytes) {
  State& state = *state_;
  const std::size_t before = state.n_batches;
  state.pending += bytes;
  if (!state.has_started) state.read_start();
  if (!state.has_started) return 0;
  try {
    while (state.read_chunk()) {
    }
  } catch (const std::out_of_range& error) {
    state.fail(error.what());
  }
  if (state.is_complete && !state.pending.empty()) state.fail("there is something after the end");
  return state.n_batches - before;
}

std::size_t PmeshReader::n_batches() const { return state_->n_batches; }
bool PmeshReader::is_complete() const { return state_->is_complete; }

ProgressiveMesh PmeshReader::mesh() const {
  if (!state_->codec) state_->fail("the base hasn't come yet");
  const bool in_input_numbers = state_->numbering.has_value();
  return assemble(*state_->codec, in_input_numbers ? &*state_->numbering : nullptr);
}

ProgressiveMesh read_pmesh(const std::filesystem::path& path) {
  PmeshReader reader(path.string());
  const std::string content = read_whole_file(path);
  reader.feed(content);
  if (!reader.is_complete())
    throw InputError::at_byte(path.string(), content.size(), "the file ends too early");
  ProgressiveMesh mesh = reader.mesh();
  PictureLoader(path.parent_path()).load(mesh.materials);
  return mesh;
}

}  // namespace recede
