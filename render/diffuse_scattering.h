// Light that goes from place to place of a matt height field, without rays: through precomputed visibility.
#pragma once

#include <recede/render/curved_visibility.h>
#include <recede/render/height_field_visibility.h>

#include <functional>
#include <span>
#include <vector>

namespace recede {

/// One scattering of light at a matt surface as a pass over all places: what reaches each of them of what the
/// others send out. All places use the same directions (the method of dependent tests in Heidrich, Daubert,
/// Kautz and Seidel 2000), weighted by cosines; weights of a place sum to 1 with those of the sky, so that no
/// light is won or lost whatever the directions are.
class DiffuseTransport {
 public:
  /// Throws what `bend_directions` throws.
  explicit DiffuseTransport(const HeightFieldVisibility& visibility, const BaseCurvature& curvature = {});

  std::size_t place_count() const { return sky_.size(); }

  /// For each place the mean of what it sees, `lanes` numbers that lie side by side: `from` and `to` hold as
  /// many for each place, and don't overlap. Runs in the calling thread.
  void gather(std::span<const double> from, std::size_t lanes, std::span<double> to) const;

  /// The share of each place's light that comes from the sky when that is equally bright all around.
  const std::vector<double>& sky() const { return sky_; }
  /// The mean over each place of what a sky sends that isn't: `radiance` by direction, in the frame of the
  /// surface.
  std::vector<double> sky_light(const std::function<double(const Vec3&)>& radiance) const;

  /// Closes a series of `orders` orders (see `ScatteredLight`): with it as the share that meets the surface
  /// again after the last of them and after all that follow, a surface of albedo 1 under an even sky is as
  /// bright as the sky, over the whole plane. 0 for a flat one.
  double hits_again(int orders) const;

 private:
  struct Source {
    std::uint32_t place;
    float weight;
  };
  struct Gap {
    Vec3 direction;
    double weight;
  };

  std::vector<double> sky_;
  std::vector<std::size_t> first_source_{0}, first_gap_{0};
  std::vector<Source> sources_;
  std::vector<Gap> gaps_;
};

/// Light by how often it has met the surface, each for albedo 1: order 1 comes straight from the source,
/// order 2 by way of one other place, and so on. A surface of another albedo has order k times albedo^k.
struct ScatteredLight {
  std::vector<std::vector<double>> orders{};  ///< by order, place: irradiance, as `first` was given
  /// Of what the last order sends out, the share that meets the surface again and again: closes the series.
  double hits_again = 0;

  /// The whole irradiance of a place: sum over k of albedo^(k - 1) times order k. Times albedo / pi it is the
  /// radiance that the place sends out. `last` leaves out what has met the surface more often, 0 nothing.
  double irradiance(std::size_t place, double albedo, int last = 0) const;
};

/// `first` is the irradiance of each place as it comes from sun and sky, 1 for what faces the sun. Throws
/// `OptionError` for orders outside of 1 to 64 and `InputError` unless there is a finite number for each
/// place.
ScatteredLight scatter_light(const DiffuseTransport& transport, std::vector<double> first, int orders = 4);

/// Irradiance of each place by parallel light from a unit direction: max(0, N.L) times how far the place is
/// open to it, which `openness` says, from 0 to 1. Places that face away aren't asked for.
std::vector<double> direct_light(const HeightFieldVisibility& visibility, const Vec3& toward_light,
                                 const std::function<double(std::size_t place)>& openness);

}  // namespace recede
