// A take through ScanNet's own class (SensReader/c++/src/sensorData.h): sens_writer TAKE OUT.sens
// TAKE: int32 count, width, height; float fx, fy, cx, cy, counts per metre; uint64 stamps [us]; float poses, 4 x 4 by
// rows; uint8 colours; uint16 depth.
#include <cstdint>
#include "sensorData.h"

int main(int argc, char** argv) {
    if (argc != 3) return 2;
    std::ifstream file(argv[1], std::ios::binary);
    int32_t size[3];
    float lens[5];
    file.read((char*)size, sizeof size).read((char*)lens, sizeof lens);
    const size_t count = size[0], pixels = (size_t)size[1] * size[2];
    std::vector<uint64_t> stamps(count);
    std::vector<ml::mat4f> poses(count);
    std::vector<ml::vec3uc> color(count * pixels);
    std::vector<uint16_t> depth(count * pixels);
    file.read((char*)stamps.data(), 8 * count).read((char*)poses.data(), 64 * count);
    file.read((char*)color.data(), 3 * color.size()).read((char*)depth.data(), 2 * depth.size());
    typedef ml::SensorData Data;
    const Data::CalibrationData camera(Data::CalibrationData::makeIntrinsicMatrix(lens[0], lens[1], lens[2], lens[3]));
    Data data;
    data.initDefault(size[1], size[2], size[1], size[2], camera, camera, Data::TYPE_RAW, Data::TYPE_ZLIB_USHORT, lens[4],
                     "judge");
    for (size_t i = 0; i < count; ++i)
        data.addFrame(color.data() + i * pixels, depth.data() + i * pixels, poses[i], stamps[i], stamps[i]);
    data.saveToFile(std::string(argv[2]));
    return 0;
}
