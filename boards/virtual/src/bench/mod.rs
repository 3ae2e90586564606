//! The object on its cords, the hammer, the sensors, the ADC.
