#include <recede/lod/detail/pmesh_codec.h>

#include <algorithm>
#include <bit>
#include <cmath>

namespace recede::detail {
namespace {

enum Flag : std::uint32_t {
  k_uvs = 1,
  k_normals = 2,
  k_colors = 4,
  k_features = 8,
  k_face_materials = 16,
  k_keeps_order = 32,
  k_proved = 64,
  k_numbering = 128,
  k_last_flag = 256
};

/// Fields one after the other, as bytes of one kind.
struct FieldCoder {
  ByteStreams& streams;
  bool writes;

  template <typename Integer>
  void integer(Integer& value) {
    for (std::size_t i = 0; i < sizeof(Integer); ++i) {
      if (writes)
        streams.put(ByteKind::raw, static_cast<std::uint8_t>(static_cast<std::uint64_t>(value) >> (8 * i)));
      else
        value = static_cast<Integer>(
            (i == 0 ? Integer{0} : value) |
            static_cast<Integer>(static_cast<Integer>(streams.take(ByteKind::raw)) << (8 * i)));
    }
  }
  void real(double& value) {
    auto bits = std::bit_cast<std::uint64_t>(value);
    integer(bits);
    value = std::bit_cast<double>(bits);
  }
  void text(std::string& value) {
    auto size = static_cast<std::uint32_t>(value.size());
    integer(size);
    if (!writes) {
      if (size > streams.left(ByteKind::raw)) throw std::out_of_range("a text is longer than the header");
      value.resize(size);
    }
    for (char& c : value) {
      auto byte = static_cast<std::uint8_t>(c);
      integer(byte);
      c = static_cast<char>(byte);
    }
  }
  template <typename List, typename Visit>
  void list(List& values, Visit&& visit) {
    auto size = static_cast<std::uint32_t>(values.size());
    integer(size);
    if (!writes) {
      if (size > streams.left(ByteKind::raw)) throw std::out_of_range("a list is longer than the header");
      values.resize(size);
    }
    for (auto& value : values) visit(value);
  }
  void lattice(NumberLattice& value) {
    auto form = static_cast<std::uint8_t>(value.form);
    integer(form);
    if (form > static_cast<std::uint8_t>(NumberLattice::Form::quantised)) {
      throw std::out_of_range("numbers in an unknown form");
    }
    value.form = static_cast<NumberLattice::Form>(form);
    real(value.origin);
    real(value.step);
    auto most = static_cast<std::uint64_t>(value.most);
    integer(most);
    value.most = static_cast<std::int64_t>(most);
    if (!std::isfinite(value.origin) || !(value.step > 0) || !std::isfinite(value.step) || value.most < 0) {
      throw std::out_of_range("numbers with an unusable unit");
    }
  }
};

}  // namespace

void PmeshCodec::code_header(ByteStreams& streams, PmeshHeader& header, bool writes) {
  FieldCoder fields{streams, writes};
  std::uint32_t flags = 0;
  const auto flag = [&](bool& value, Flag bit) {
    if (writes)
      flags |= value ? bit : 0u;
    else
      value = (flags & bit) != 0;
  };
  const auto code_flags = [&] {
    flag(header.has_uvs, k_uvs);
    flag(header.has_normals, k_normals);
    flag(header.has_colors, k_colors);
    flag(header.has_features, k_features);
    flag(header.has_face_materials, k_face_materials);
    flag(header.keeps_order, k_keeps_order);
    flag(header.errors_are_proved, k_proved);
    flag(header.has_numbering, k_numbering);
  };
  if (writes) code_flags();
  fields.integer(flags);
  require(flags < k_last_flag, "the header has flags of a later version");
  if (!writes) code_flags();
  fields.integer(header.n_splits);
  fields.integer(header.n_batches);
  fields.real(header.quantisation_error);
  for (NumberLattice* const lattice :
       {&header.positions, &header.uvs, &header.normals, &header.colors, &header.scalars}) {
    fields.lattice(*lattice);
  }
  fields.list(header.scalar_names, [&](std::string& name) { fields.text(name); });
  for (std::size_t i = 0; i < header.scalar_names.size(); ++i) {
    const auto end = header.scalar_names.begin() + static_cast<std::ptrdiff_t>(i);
    require(!end->empty() && std::find(header.scalar_names.begin(), end, *end) == end,
            "scalars without names or with the same one");
  }
  fields.list(header.materials, [&](Material& material) {
    fields.text(material.name);
    for (int i = 0; i < 4; ++i) fields.real(material.base_color[i]);
    fields.text(material.base_color_texture);
  });
}

}  // namespace recede::detail
