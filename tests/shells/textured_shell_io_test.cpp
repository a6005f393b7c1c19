#include "simple_soups.h"
#include "temp_folder.h"
#include <recede/geometry/error.h>
#include <recede/shells/procedural_volumes.h>
#include <recede/shells/shell_edit.h>
#include <recede/shells/textured_shell_io.h>

#include <gmock/gmock.h>
#include <zstd.h>

#include <random>

namespace {

using namespace recede;
using recede::test::TempFolder;
using testing::HasSubstr;
using testing::ThrowsMessage;

TexturedShell textured(ShellSide side, bool in_color) {
  PolygonSoup base = test::grid(6);
  for (const Index v : base.corner_vertices) base.corner_uvs.push_back(base.positions[v].head<2>() / 6);
  if (in_color) base.vertex_colors.assign(base.positions.size(), Vec4(0.5, 0.25, 0.125, 1));
  TexturedShell shell{
      .shell = std::make_shared<const Shell>(build_shell(base, {.thickness = 0.5, .side = side})),
      .side = side,
      .coordinates = {.repeat = {3, -2}, .offset = {0.25, 0.5}}};
  shell.texture = finest_only(make_volume(in_color ? weave() : chain_mail(), 8));
  return shell;
}

TEST(TexturedShellFile, HoldsWhatWasWritten) {
  const TempFolder folder;
  for (const ShellSide side : {ShellSide::exterior, ShellSide::interior}) {
    for (const bool in_color : {false, true}) {
      const TexturedShell written = textured(side, in_color);
      write_textured_shell(folder / "a.shell", written);
      const TexturedShell read = read_textured_shell(folder / "a.shell", {.make_mipmap = false});
      EXPECT_EQ(read.side, side);
      EXPECT_EQ(read.shell->base.positions, written.shell->base.positions);
      EXPECT_EQ(read.shell->base.corner_vertices, written.shell->base.corner_vertices);
      EXPECT_EQ(read.shell->base.corner_uvs, written.shell->base.corner_uvs);
      EXPECT_EQ(read.shell->quads, written.shell->quads);
      EXPECT_EQ(read.layer().hexahedra, written.layer().hexahedra);
      EXPECT_EQ(read.shell->base.vertex_colors, written.shell->base.vertex_colors);
      EXPECT_EQ(read.shell->thicknesses, written.shell->thicknesses);
      EXPECT_EQ(read.layer().tops, written.layer().tops);
      EXPECT_TRUE(read.layer().validity.is_valid());
      EXPECT_EQ(read.coordinates.repeat, written.coordinates.repeat);
      EXPECT_EQ(read.coordinates.offset, written.coordinates.offset);
      const VolumeTexture &a = read.texture->surfaces.front(), &b = written.texture->surfaces.front();
      EXPECT_EQ(a.size, b.size);
      EXPECT_EQ(a.opacity, b.opacity);
      EXPECT_EQ(a.colors, b.colors);
      EXPECT_EQ(a.is_periodic, b.is_periodic);
      EXPECT_EQ(a.extent, b.extent);
      EXPECT_EQ(a.ramp, b.ramp);
      EXPECT_TRUE(read.texture->transparent.empty());
      write_textured_shell(folder / "b.shell", read);
      EXPECT_EQ(read_whole_file(folder / "b.shell"), read_whole_file(folder / "a.shell"));
    }
  }
}

TEST(TexturedShellFile, MakesSmallerVersionsOfTheTexture) {
  const TempFolder folder;
  const TexturedShell written = textured(ShellSide::exterior, false);
  write_textured_shell(folder / "a.shell", written);
  const VolumeMipmap expected = make_mipmap(written.texture->surfaces.front());
  const TexturedShell read = read_textured_shell(folder / "a.shell");
  ASSERT_EQ(read.texture->n_levels(), expected.n_levels());
  EXPECT_EQ(read.texture->transparent.back().opacity, expected.transparent.back().opacity);
}

/// What a frame holds, in another frame that is sound.
class Payload {
 public:
  explicit Payload(const std::string& file) : head_(file.substr(0, file.find('\n') + 1)) {
    content_.resize(ZSTD_getFrameContentSize(file.data() + head_.size(), file.size() - head_.size()));
    ZSTD_decompress(content_.data(), content_.size(), file.data() + head_.size(), file.size() - head_.size());
  }
  std::string& content() { return content_; }
  std::string file() const {
    std::string frame(ZSTD_compressBound(content_.size()), '\0');
    frame.resize(ZSTD_compress(frame.data(), frame.size(), content_.data(), content_.size(), 1));
    return head_ + frame;
  }

 private:
  std::string head_, content_;
};

// Files of the first version know no quads.
TEST(TexturedShellFile, IsReadAsItWasWrittenBefore) {
  const TempFolder folder;
  const TexturedShell written = textured(ShellSide::exterior, true);
  write_textured_shell(folder / "a.shell", written);
  Payload payload(read_whole_file(folder / "a.shell"));
  const std::size_t n_vertices = written.shell->base.positions.size(),
                    n_triangles = written.shell->base.n_faces(), n_quads = written.shell->quads.size();
  ASSERT_GT(n_quads, 0u);
  payload.content().erase(16 + 7 * 8 * n_vertices + 12 * n_triangles, 4 + 4 * n_quads);
  std::string file = payload.file();
  file.replace(file.find("shell 2"), 7, "shell 1");
  write_file_atomically(folder / "b.shell", file);
  const TexturedShell read = read_textured_shell(folder / "b.shell", {.make_mipmap = false});
  EXPECT_EQ(read.shell->base.corner_uvs, written.shell->base.corner_uvs);
  EXPECT_EQ(read.layer().tops, written.layer().tops);
  EXPECT_EQ(read.texture->surfaces.front().colors, written.texture->surfaces.front().colors);
  EXPECT_TRUE(read.shell->quads.empty());
  EXPECT_TRUE(read.layer().hexahedra.empty());
}

// The checksum is right, the numbers are not: each file is read or refused, whatever they say.
TEST(TexturedShellFile, IsReadOrRefusedWhateverItsNumbersAre) {
  const TempFolder folder;
  write_textured_shell(folder / "a.shell", textured(ShellSide::exterior, true));
  const Payload sound(read_whole_file(folder / "a.shell"));
  std::mt19937 random(4);
  int refused = 0;
  constexpr int k_files = 400;
  for (int n = 0; n < k_files; ++n) {
    Payload changed = sound;
    std::string& content = changed.content();
    std::uniform_int_distribution<std::size_t> any(0, content.size() - 1);
    if (n % 4 == 0) {
      content.resize(any(random));
    } else {
      // Half of them in the counts at the beginning, which matter most.
      const std::size_t at = n % 2 == 0 ? any(random) % 16 : any(random);
      content[at] = static_cast<char>(random());
    }
    write_file_atomically(folder / "b.shell", changed.file());
    try {
      read_textured_shell(folder / "b.shell", {.make_mipmap = false});
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("b.shell"));
      ++refused;
    }
  }
  EXPECT_GT(refused, k_files / 4);
  Payload longer = sound;
  longer.content() += "x";
  write_file_atomically(folder / "b.shell", longer.file());
  EXPECT_THAT([&] { read_textured_shell(folder / "b.shell"); },
              ThrowsMessage<InputError>(HasSubstr("more than a textured shell")));
}

TEST(TexturedShellFile, IsRefusedWhereItsTextureRepeatsZeroTimes) {
  const TempFolder folder;
  const TexturedShell written = textured(ShellSide::exterior, false);
  write_textured_shell(folder / "a.shell", written);
  Payload payload(read_whole_file(folder / "a.shell"));
  const std::size_t n_vertices = written.shell->base.positions.size(),
                    n_triangles = written.shell->base.n_faces(), n_quads = written.shell->quads.size(),
                    at = 16 + 7 * 8 * n_vertices + 12 * n_triangles + 4 + 4 * n_quads + 6 * 8 * n_triangles;
  payload.content().replace(at, 8, 8, '\0');
  write_file_atomically(folder / "b.shell", payload.file());
  EXPECT_THAT([&] { read_textured_shell(folder / "b.shell", {.make_mipmap = false}); },
              ThrowsMessage<InputError>(HasSubstr("b.shell: a texture that repeats 0 times")));
}

// A fuzzer found it: a frame of some bytes that says it holds 32 GiB.
TEST(TexturedShellFile, IsRefusedBeforeThereIsMemoryForWhatItClaims) {
  const TempFolder folder;
  std::string bytes = "recede textured shell 2\n";
  bytes += std::string("\x28\xb5\x2f\xfd\xe0\0\0\0\0\x08\0\0\0\x01\0\0", 16);
  write_file_atomically(folder / "a.shell", bytes);
  EXPECT_THAT([&] { read_textured_shell(folder / "a.shell"); },
              ThrowsMessage<InputError>(HasSubstr("a.shell: the file is damaged")));
}

TEST(TexturedShellFile, IsRefusedWhenItIsDamaged) {
  const TempFolder folder;
  write_textured_shell(folder / "a.shell", textured(ShellSide::exterior, true));
  const std::string bytes = read_whole_file(folder / "a.shell");
  const auto read = [&](const std::string& content) {
    write_file_atomically(folder / "b.shell", content);
    read_textured_shell(folder / "b.shell");
  };
  EXPECT_THAT([&] { read("ply\n" + bytes); },
              ThrowsMessage<InputError>(HasSubstr("b.shell: this is no textured shell")));
  EXPECT_THAT([&] { read(bytes + "x"); },
              ThrowsMessage<InputError>(HasSubstr("b.shell: the file is damaged")));
  EXPECT_THROW(read(""), InputError);
  std::mt19937 random(2);
  for (std::size_t n = 0; n < bytes.size(); n += 1 + n / 8)
    EXPECT_THROW(read(bytes.substr(0, n)), InputError);
  for (int n = 0; n < 100; ++n) {
    std::string changed = bytes;
    // The checksum finds every changed byte.
    changed[std::uniform_int_distribution<std::size_t>(0, bytes.size() - 1)(random)] ^= 0x11;
    EXPECT_THROW(read(changed), InputError);
  }
  EXPECT_THAT([&] { read_textured_shell(folder / "none.shell"); },
              ThrowsMessage<InputError>(HasSubstr("none.shell")));
  TexturedShell without = textured(ShellSide::exterior, false);
  without.texture = nullptr;
  EXPECT_THROW(write_textured_shell(folder / "c.shell", without), InputError);
  EXPECT_FALSE(std::filesystem::exists(folder / "c.shell"));
}

}  // namespace
