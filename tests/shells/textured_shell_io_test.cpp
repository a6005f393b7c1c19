#include "simple_soups.h"
#include "temp_folder.h"
#include <recede/geometry/error.h>
#include <recede/shells/procedural_volumes.h>
#include <recede/shells/shell_edit.h>
#include <recede/shells/textured_shell_io.h>

#include <gmock/gmock.h>

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
  shell.texture =
      std::make_shared<const VolumeMipmap>(make_mipmap(make_volume(in_color ? weave() : chain_mail(), 8)));
  return shell;
}

TEST(TexturedShellFile, HoldsWhatWasWritten) {
  const TempFolder folder;
  for (const ShellSide side : {ShellSide::exterior, ShellSide::interior}) {
    for (const bool in_color : {false, true}) {
      const TexturedShell written = textured(side, in_color);
      write_textured_shell(folder / "a.shell", written);
      const TexturedShell read = read_textured_shell(folder / "a.shell");
      EXPECT_EQ(read.side, side);
      EXPECT_EQ(read.shell->base.positions, written.shell->base.positions);
      EXPECT_EQ(read.shell->base.corner_vertices, written.shell->base.corner_vertices);
      EXPECT_EQ(read.shell->base.corner_uvs, written.shell->base.corner_uvs);
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
      EXPECT_EQ(read.texture->n_levels(), written.texture->n_levels());
      write_textured_shell(folder / "b.shell", read);
      EXPECT_EQ(read_whole_file(folder / "b.shell"), read_whole_file(folder / "a.shell"));
    }
  }
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
