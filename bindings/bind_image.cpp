// Pictures from and to files, as arrays [height, width, channels] of linear floats, rows bottom up.
#include "arrays.h"
#include "bind.h"
#include "film/image_io.h"

namespace ajar::python {

void bind_image(py::module_& module) {
  module.def(
      "read_image",
      [](const std::string& path) {
        Image image;
        {
          py::gil_scoped_release release;
          image = read_image(path);
        }
        const std::vector<size_t> shape{size_t(image.height), size_t(image.width), size_t(image.channels)};
        return take_array(std::move(image.pixels), shape);
      },
      py::arg("path"), "Linear floats [height, width, channels], rows bottom up.");
  module.def(
      "read_channels",
      [](const std::string& path) {
        Image image;
        {
          py::gil_scoped_release release;
          image = read_image(path);
        }
        py::dict channels;
        for (int c = 0; c < image.channels; ++c) {
          py::array_t<float> values({image.height, image.width});
          for (py::ssize_t i = 0; i < values.size(); ++i) values.mutable_data()[i] = image.pixels[i * image.channels + c];
          channels[py::str(image.channel_names[c])] = values;
        }
        return channels;
      },
      py::arg("path"), "Every channel [height, width] of a file by its name, such as those of a multilayer EXR.");
  module.def(
      "write_image",
      [](const std::string& path, const Floats& pixels, const std::map<std::string, std::string>& metadata) {
        if (pixels.ndim() != 2 && pixels.ndim() != 3)
          throw py::value_error("pixels must be an array [height, width, channels], not " + shape_text(pixels));
        Image image{int(pixels.shape(1)), int(pixels.shape(0)), pixels.ndim() == 3 ? int(pixels.shape(2)) : 1, {}};
        image.pixels = copy_numbers(pixels);
        py::gil_scoped_release release;
        write_image(path, image, metadata);
      },
      py::arg("path"), py::arg("pixels"), py::arg("metadata") = std::map<std::string, std::string>{},
      ".exr: float, linear. .png: 8 bits, sRGB.");
}

}  // namespace ajar::python
