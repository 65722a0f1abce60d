// A stand-in for the parts of the Arduino core for the ESP32 that examples/arduino uses, with its types.

#pragma once
#include <cstdint>
#include <cstring>
#include <deque>

typedef struct Queue *QueueHandle_t;
typedef unsigned UBaseType_t;
typedef int BaseType_t;
typedef uint32_t TickType_t;
const BaseType_t pdTRUE = 1;

QueueHandle_t xQueueCreate(UBaseType_t length, UBaseType_t size);
BaseType_t xQueueSend(QueueHandle_t queue, const void *item, TickType_t wait);
BaseType_t xQueueReceive(QueueHandle_t queue, void *item, TickType_t wait);

struct SerialPort {
  void begin(unsigned long baud);
  void println(const char *line);
};
extern SerialPort Serial;

unsigned long millis();
uint32_t esp_random();
