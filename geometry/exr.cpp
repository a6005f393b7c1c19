#include <recede/geometry/atomic_file.h>
#include <recede/geometry/error.h>
#include <recede/geometry/exr.h>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfStandardAttributes.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <set>

namespace recede {
namespace {

class StringWriter final : public Imf::OStream {
 public:
  StringWriter() : Imf::OStream("") {}

  void write(const char* bytes, int count) override {
    const std::size_t end = at_ + static_cast<std::size_t>(count);
    if (end > bytes_.size()) bytes_.resize(end);
    std::memcpy(bytes_.data() + at_, bytes, static_cast<std::size_t>(count));
    at_ = end;
  }
  std::uint64_t tellp() override { return at_; }
  void seekp(std::uint64_t place) override { at_ = place; }

  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
  std::size_t at_ = 0;
};

class StringReader final : public Imf::IStream {
 public:
  StringReader(std::string_view bytes, const std::string& name) : Imf::IStream(name.c_str()), bytes_(bytes) {}

  bool read(char* to, int count) override {
    const auto wanted = static_cast<std::size_t>(count);
    if (count < 0 || at_ > bytes_.size() || wanted > bytes_.size() - at_)
      throw Error("the file ends too early");
    std::memcpy(to, bytes_.data() + at_, wanted);
    at_ += wanted;
    return at_ < bytes_.size();
  }
  std::uint64_t tellg() override { return at_; }
  void seekg(std::uint64_t place) override { at_ = place; }

 private:
  std::string_view bytes_;
  std::size_t at_ = 0;
};

/// One slice for each channel of interleaved samples, floats or halves.
template <typename Sample>
Imf::FrameBuffer frame_of(const std::vector<std::string>& channels, const Sample* samples,
                          const Imath::Box2i& window) {
  const std::size_t texel = channels.size() * sizeof(Sample);
  const std::size_t row = texel * static_cast<std::size_t>(window.max.x - window.min.x + 1);
  const Imf::PixelType type = std::is_same_v<Sample, half> ? Imf::HALF : Imf::FLOAT;
  Imf::FrameBuffer frame;
  for (std::size_t c = 0; c < channels.size(); ++c)
    frame.insert(channels[c], Imf::Slice::Make(type, samples + c, window, texel, row));
  return frame;
}

/// R, G, B and A first, then the others as OpenEXR sorts them.
std::vector<std::string> names_of(const Imf::ChannelList& list) {
  std::vector<std::string> names;
  for (auto channel = list.begin(); channel != list.end(); ++channel) names.emplace_back(channel.name());
  const auto rank = [](const std::string& name) {
    constexpr std::array<std::string_view, 4> k_first{"R", "G", "B", "A"};
    return std::find(k_first.begin(), k_first.end(), name) - k_first.begin();
  };
  std::stable_sort(names.begin(), names.end(),
                   [&](const std::string& a, const std::string& b) { return rank(a) < rank(b); });
  return names;
}

FloatRaster decode(std::string_view bytes, const std::string& name) {
  StringReader stream(bytes, name);
  Imf::InputFile file(stream, 0);
  const Imath::Box2i window = file.header().dataWindow();
  const Imf::ChannelList& list = file.header().channels();
  for (auto channel = list.begin(); channel != list.end(); ++channel) {
    if (channel.channel().xSampling != 1 || channel.channel().ySampling != 1)
      throw Error("subsampled channels aren't supported");
  }
  FloatRaster raster;
  raster.channels = names_of(list);
  if (raster.channels.empty()) throw Error("there are no channels");
  raster.width = window.max.x - window.min.x + 1;
  raster.height = window.max.y - window.min.y + 1;
  const std::size_t n = static_cast<std::size_t>(raster.width) * static_cast<std::size_t>(raster.height) *
                        raster.channels.size();
  // No compression comes near this, so a small file can't ask for all memory.
  constexpr std::size_t k_most_samples_per_byte = 4096;
  if (n / k_most_samples_per_byte > bytes.size()) throw Error("the file ends too early");
  raster.samples.resize(n);
  file.setFrameBuffer(frame_of(raster.channels, raster.samples.data(), window));
  file.readPixels(window.min.y, window.max.y);
  return raster;
}

std::string encode(const FloatRaster& raster, const ExrOptions& options) {
  Imf::Header header(raster.width, raster.height);
  header.compression() = Imf::ZIP_COMPRESSION;
  if (!options.comments.empty()) Imf::addComments(header, options.comments);
  for (const std::string& channel : raster.channels)
    header.channels().insert(channel, Imf::Channel(options.half ? Imf::HALF : Imf::FLOAT));
  std::vector<half> halves;  // OpenEXR converts when it reads only
  if (options.half) halves.assign(raster.samples.begin(), raster.samples.end());
  StringWriter stream;
  {
    const Imath::Box2i& window = header.dataWindow();
    Imf::OutputFile file(stream, header, 0);
    file.setFrameBuffer(options.half ? frame_of(raster.channels, halves.data(), window)
                                     : frame_of(raster.channels, raster.samples.data(), window));
    file.writePixels(raster.height);
  }  // which writes where the lines begin
  return stream.take();
}

/// OpenEXR's reasons name the file and may have several lines.
std::string one_line(std::string reason, const std::string& name) {
  for (const std::string& around : {" \"" + name + "\"", "\"" + name + "\""}) {
    const std::size_t found = reason.find(around);
    if (found != std::string::npos) reason.erase(found, around.size());
  }
  std::replace(reason.begin(), reason.end(), '\n', ' ');
  return reason;
}

}  // namespace

std::string encode_exr(const FloatRaster& raster, const ExrOptions& options) {
  const auto width = static_cast<std::size_t>(raster.width), height = static_cast<std::size_t>(raster.height);
  const bool named = std::set<std::string>(raster.channels.begin(), raster.channels.end()).size() ==
                         raster.channels.size() &&
                     std::find(raster.channels.begin(), raster.channels.end(), "") == raster.channels.end();
  if (raster.width <= 0 || raster.height <= 0 || raster.channels.empty() || !named ||
      raster.samples.size() != width * height * raster.channels.size()) {
    throw OptionError("an OpenEXR file needs texels, channels with different names, and samples for them");
  }
  try {
    return encode(raster, options);
  } catch (const std::exception& error) {
    throw Error(std::string("OpenEXR: ") + error.what());
  }
}

FloatRaster decode_exr(std::string_view bytes, const std::string& name) {
  try {
    return decode(bytes, name);
  } catch (const std::exception& error) {
    throw InputError::in_file(name, one_line(error.what(), name));
  }
}

FloatRaster read_exr(const std::filesystem::path& path) {
  return decode_exr(read_whole_file(path), path.string());
}

}  // namespace recede
