// Image files as arrays [height, width, channels] of linear floats, rows from the bottom up.
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
      py::arg("path"),
      "Read an image file and return float32[height, width, channels], rows from the bottom up. 8-bit files are "
      "decoded from sRGB and their colours are multiplied by alpha, so that values are linear. Float files are "
      "returned as they are. Raises RuntimeError, which names the file, when it cannot be read.");
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
          for (py::ssize_t i = 0; i < values.size(); ++i)
            values.mutable_data()[i] = image.pixels[i * image.channels + c];
          channels[py::str(image.channel_names[c])] = values;
        }
        return channels;
      },
      py::arg("path"),
      "Read an image file and return a dict from the name of each channel to float32[height, width], rows from the "
      "bottom up, such as the channels of a multilayer EXR file. Values are those of read_image. Raises RuntimeError, "
      "which names the file, when it cannot be read.");
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
      "Write pixels, float32[height, width, channels] or float32[height, width], linear, rows from the bottom up, to a "
      "file. The file extension selects the format: .exr stores the floats, .png 8 bits in sRGB with straight alpha, 1 "
      "to 4 channels. metadata: texts to store by name. Raises ValueError for an array of another number of "
      "dimensions, and RuntimeError, which names the file, when it cannot be written.");
}

}  // namespace ajar::python
