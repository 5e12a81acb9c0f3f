// A driver of OpenNI2 that plays the frames of one file as a depth camera, and (with -DRECORD) the program that lets
// OpenNI2's own recorder write them. tools/formats/writers/openni.py compiles and runs both.
// The file: int32 count, width, height; float horizontal and vertical field of view [rad]; uint64 stamps [us];
// uint16 millimetres.
#ifdef RECORD
#include <OpenNI.h>
#include <cstdio>
#include <cstdlib>
#include <unistd.h>

int main(int argc, char** argv) {
    using namespace openni;
    Device device;
    VideoStream depth;
    Recorder recorder;
    if (argc != 3 || OpenNI::initialize() || device.open("Judge") || depth.create(device, SENSOR_DEPTH) ||
        recorder.create(argv[1]) || recorder.attach(depth, FALSE) || recorder.start() || depth.start()) {
        fprintf(stderr, "%s\n", OpenNI::getExtendedError());
        return 1;
    }
    sleep(atoi(argv[2]));
    recorder.stop();
    recorder.destroy();
    depth.destroy();
    device.close();
    OpenNI::shutdown();
    return 0;
}
#else
#define XN_NEW(type, arg) new type(arg)
#define XN_DELETE(p) delete (p)
#include "Driver/OniDriverAPI.h"
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <thread>
#include <unistd.h>
#include <vector>

struct Frames {
    int32_t count = 0, width = 0, height = 0;
    float across = 0, down = 0;
    std::vector<uint64_t> stamps;
    std::vector<uint16_t> depth;
    Frames() {
        std::ifstream file(getenv("JUDGE_FRAMES"), std::ios::binary);
        file.read((char*)&count, 12).read((char*)&across, 8);
        stamps.resize(count);
        depth.resize((size_t)count * width * height);
        file.read((char*)stamps.data(), 8 * stamps.size()).read((char*)depth.data(), 2 * depth.size());
    }
    OniVideoMode mode() const { return {ONI_PIXEL_FORMAT_DEPTH_1_MM, width, height, 30}; }
};

class Stream : public oni::driver::StreamBase {
public:
    explicit Stream(const Frames& frames) : m_frames(frames) {}
    ~Stream() { stop(); }
    OniStatus start() {
        m_running = true;
        m_thread = std::thread([this] { play(); });
        return ONI_STATUS_OK;
    }
    void stop() {
        m_running = false;
        if (m_thread.joinable()) m_thread.join();
    }
    OniStatus getProperty(int id, void* data, int* size) {
        if (id == ONI_STREAM_PROPERTY_VIDEO_MODE) return give(m_frames.mode(), data, size);
        if (id == ONI_STREAM_PROPERTY_HORIZONTAL_FOV) return give(m_frames.across, data, size);
        if (id == ONI_STREAM_PROPERTY_VERTICAL_FOV) return give(m_frames.down, data, size);
        if (id == ONI_STREAM_PROPERTY_MAX_VALUE) return give((int)10000, data, size);
        if (id == ONI_STREAM_PROPERTY_MIRRORING) return give((OniBool)FALSE, data, size);
        return ONI_STATUS_NOT_IMPLEMENTED;
    }
    OniBool isPropertySupported(int id) { return id >= 1 && id <= 7; }
    void notifyAllProperties() {
        raisePropertyChanged(ONI_STREAM_PROPERTY_HORIZONTAL_FOV, &m_frames.across, sizeof(float));
        raisePropertyChanged(ONI_STREAM_PROPERTY_VERTICAL_FOV, &m_frames.down, sizeof(float));
        OniVideoMode mode = m_frames.mode();
        raisePropertyChanged(ONI_STREAM_PROPERTY_VIDEO_MODE, &mode, sizeof(mode));
        OniBool mirrored = FALSE;
        raisePropertyChanged(ONI_STREAM_PROPERTY_MIRRORING, &mirrored, sizeof(mirrored));
    }

private:
    template <typename T> OniStatus give(T value, void* data, int* size) {
        if (*size != (int)sizeof(T)) return ONI_STATUS_ERROR;
        memcpy(data, &value, sizeof(T));
        return ONI_STATUS_OK;
    }
    void play() {
        usleep(300000);
        const size_t pixels = (size_t)m_frames.width * m_frames.height;
        for (int i = 0; m_running && i < m_frames.count; ++i, usleep(atoi(getenv("JUDGE_PAUSE_US")))) {
            OniFrame* frame = getServices().acquireFrame();
            if (!frame) continue;
            memcpy(frame->data, m_frames.depth.data() + i * pixels, 2 * pixels);
            frame->frameIndex = i + 1;
            frame->videoMode = m_frames.mode();
            frame->width = m_frames.width;
            frame->height = m_frames.height;
            frame->cropOriginX = frame->cropOriginY = 0;
            frame->croppingEnabled = FALSE;
            frame->sensorType = ONI_SENSOR_DEPTH;
            frame->stride = 2 * m_frames.width;
            frame->timestamp = m_frames.stamps[i];
            raiseNewFrame(frame);
            getServices().releaseFrame(frame);
        }
    }
    const Frames& m_frames;
    std::atomic<bool> m_running{false};
    std::thread m_thread;
};

class Camera : public oni::driver::DeviceBase {
public:
    Camera() : m_mode(m_frames.mode()) { m_sensor = {ONI_SENSOR_DEPTH, 1, &m_mode}; }
    OniStatus getSensorInfoList(OniSensorInfo** sensors, int* count) {
        *sensors = &m_sensor;
        *count = 1;
        return ONI_STATUS_OK;
    }
    oni::driver::StreamBase* createStream(OniSensorType) { return new Stream(m_frames); }
    void destroyStream(oni::driver::StreamBase* stream) { delete stream; }

private:
    Frames m_frames;
    OniVideoMode m_mode;
    OniSensorInfo m_sensor;
};

class Judge : public oni::driver::DriverBase {
public:
    explicit Judge(OniDriverServices* services) : DriverBase(services) {}
    oni::driver::DeviceBase* deviceOpen(const char*, const char*) { return new Camera; }
    void deviceClose(oni::driver::DeviceBase* device) { delete device; }
    OniStatus tryDevice(const char* uri) {
        if (strcmp(uri, "Judge")) return ONI_STATUS_ERROR;
        static OniDeviceInfo info = {};
        strcpy(info.uri, uri);
        strcpy(info.vendor, "rendered");
        strcpy(info.name, "Judge");
        deviceConnected(&info);
        return ONI_STATUS_OK;
    }
    void shutdown() {}
};

ONI_EXPORT_DRIVER(Judge)
#endif
