// Billboard clouds as Python holds them.
#pragma once

#include <recede/lod/billboard_texture.h>
#include <recede/render/billboard_reflectance.h>

#include <memory>
#include <vector>

namespace recede::python {

/// With or without textures. Shared, so that arrays and pictures outlive the lock.
struct Cloud {
  std::shared_ptr<const BillboardCloud> cloud;
  std::shared_ptr<const BillboardTextures> textures;  // or null

  const std::vector<Billboard>& billboards() const {
    return textures ? textures->billboards : cloud->billboards;
  }
};

/// Of textures that were made, or read with a hierarchy.
Cloud cloud_of(BillboardTextures textures, bool is_two_sided = false);

struct SharedReflectance {
  std::shared_ptr<const BillboardReflectance> reflectance;
};

}  // namespace recede::python
